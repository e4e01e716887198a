"""Bundle adjustment: camera, board shape and board poses together, by least squares on the reprojection error.

Huber's loss on the distance of each corner limits the influence of single bad corners.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from calibration import board_shape, lens, reprojection
from calibration.board_poses import BoardPoses
from calibration.board_shape import BoardShape, ShapeModel, flat_board
from calibration.bundle_problem import BundleProblem, apply_step
from calibration.normal_equations import BundleEquations
from calibration.stacked_views import StackedViews
from xneck_foundation.errors import Refused

DEFAULT_FREE_PARAMETERS = lens.LENS_MODELS["k1 k2 p1 p2"]


@dataclass(frozen=True)
class BundleStart:
    """Where a fit starts."""

    parameters: np.ndarray  # order of lens.PARAMETER_NAMES, shape (9,)
    poses: BoardPoses
    shape: BoardShape | None = None  # None for a flat board


@dataclass(frozen=True)
class BundleFit:
    """The least-squares estimate from a set of views."""

    parameters: np.ndarray  # order of lens.PARAMETER_NAMES, shape (9,)
    poses: BoardPoses
    free: tuple[str, ...]
    shape: BoardShape
    distances: np.ndarray  # between predicted and observed corners, zero where not visible, shape (n, c), px
    knee: float  # px; infinite for plain least squares
    covariance: np.ndarray  # of the parameters for independent equal corner errors, shape (9, 9)
    shape_covariance: np.ndarray  # of shape.values, shape (3, 3)
    converged: bool
    visible: np.ndarray  # is the corner in the view, shape (n, c)
    normal: BundleEquations  # at the solution

    @property
    def rms(self) -> float:
        """Root mean square distance over all corners, px."""
        return float(np.sqrt(np.sum(self.distances**2) / np.sum(self.visible)))

    @property
    def rms_views(self) -> np.ndarray:
        """Root mean square distance over the corners of each view, shape (n,), px."""
        return np.sqrt(np.sum(self.distances**2, axis=1) / self.visible.sum(axis=1))

    @property
    def robust_rms_views(self) -> np.ndarray:
        """Root mean of Huber's loss over the corners of each view, which single bad corners hardly raise, shape (n,), px."""
        return np.sqrt(np.sum(reprojection.huber_loss(self.distances, self.knee), axis=1) / self.visible.sum(axis=1))


def initial_estimate(views: StackedViews, image_size: tuple[int, int]) -> BundleStart:
    """A start from the views alone: focal length and poses from homographies, no distortion, a flat board.

    Raises cv2.error where OpenCV finds none (views of lines, for example).
    """
    objects = [views.nominal[visible].astype(np.float32) for visible in views.visible]
    images = [
        at[visible].astype(np.float32).reshape(-1, 1, 2)
        for at, visible in zip(views.pixels, views.visible, strict=True)
    ]
    K = cv2.initCameraMatrix2D(objects, images, image_size)
    solved = [cv2.solvePnP(o, i, K, None, flags=cv2.SOLVEPNP_IPPE)[1:] for o, i in zip(objects, images, strict=True)]
    rvecs, tvecs = (np.array(part, float).reshape(-1, 3) for part in zip(*solved, strict=True))
    parameters = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], 0.0, 0.0, 0.0, 0.0, 0.0])
    return BundleStart(parameters, BoardPoses(Rotation.from_rotvec(rvecs).as_matrix(), tvecs))


def unexplained_corners() -> Refused:
    """What is said of corners from which no fit can begin."""
    return Refused("pictures", "no camera explains the corners", "check board.yaml and take tilted views")


def fit_bundle(
    views: StackedViews,
    start: BundleStart,
    free: Sequence[str] = DEFAULT_FREE_PARAMETERS,
    shape_model: ShapeModel = board_shape.SHAPE_MODELS["rigid"],
    noise: float | None = None,
    iterations: int = 50,
) -> BundleFit:
    """Levenberg-Marquardt from a start. Parameters that are not `free` keep their value; with none free poses alone are fitted.

    `noise` is the standard deviation of a corner's coordinate, px: it sets the knee of Huber's loss and the weight of the
    board shape's prior; without it plain least squares. Raises Refused where the start leaves infinite errors.
    """
    if shape_model.offsets and noise is None:
        raise ValueError("free offsets need the corners' noise")
    problem = BundleProblem(views, tuple(free), shape_model, noise)
    p, poses = np.array(start.parameters, float), start.poses
    shape = replace(start.shape or flat_board(views.ids, views.nominal), model=shape_model)
    residuals = problem.residuals(p, shape.points, poses)
    cost = problem.cost(residuals, shape)
    if not np.isfinite(cost):
        raise unexplained_corners()
    damping, converged = 1e-6, False
    for _ in range(iterations):
        normal = problem.normal(p, shape, poses, residuals)
        while damping < 1e6:
            step, pose_steps = normal.step(damping)
            p_new, shape_new = problem.moved(p, shape, step)
            poses_new = poses.moved(pose_steps)
            new_residuals = problem.residuals(p_new, shape_new.points, poses_new)
            new_cost = problem.cost(new_residuals, shape_new)
            if new_cost <= cost:  # also false for NaN
                break
            damping *= 10
        else:
            converged = True  # no step improves: as far as floating point goes
            break
        gain = cost - new_cost
        p, shape, poses, residuals, cost = p_new, shape_new, poses_new, new_residuals, new_cost
        damping = max(damping / 10, 1e-9)
        if gain <= 1e-8 * cost + 1e-18:  # of 1000 corners: a few thousandths of a sigma
            converged = True
            break
    normal = problem.normal(p, shape, poses, residuals)
    distances = np.where(views.visible, np.linalg.norm(residuals, axis=2), 0.0)
    covariance, shape_covariance = problem.covariances(normal, distances)
    return BundleFit(
        parameters=p,
        poses=poses,
        free=problem.free,
        shape=shape,
        distances=distances,
        knee=problem.knee,
        covariance=covariance,
        shape_covariance=shape_covariance,
        converged=converged,
        visible=views.visible,
        normal=normal,
    )


def leave_out_groups(fitted: BundleFit, groups: Sequence[np.ndarray]) -> list[tuple[np.ndarray, BoardShape]]:
    """Parameters and board shape without the views of each group, by one Gauss-Newton step from the fit of all views.

    The step is of the order of sigma, where the problem is nearly linear; nothing is projected again.
    """
    estimates: list[tuple[np.ndarray, BoardShape]] = []
    for group in groups:
        step = fitted.normal.of(np.delete(np.arange(len(fitted.visible)), group)).step(0.0)[0]
        estimates.append(apply_step(fitted.parameters, fitted.shape, step, fitted.free))
    return estimates


def prediction_distances(
    views: StackedViews,
    parameters: np.ndarray,
    points: np.ndarray,
    poses: BoardPoses,
    knee: float = np.inf,
    steps: int = 4,
) -> np.ndarray:
    """Distances between predicted and observed corners, (n, c), px, with a camera (n, 9) and a board (n, c, 3) for each view.

    Only the poses are fitted, all views at once, from poses that are nearly right. A view that a step would not improve keeps
    its pose.
    """
    p = parameters[:, None, :]
    residuals = reprojection.reprojection_residuals(views, p, points, poses)
    distances = np.where(views.visible, np.linalg.norm(residuals, axis=2), 0.0)
    cost = reprojection.huber_loss(distances, knee).sum(axis=1)
    for _ in range(steps):
        _, B = reprojection.pixel_jacobians(views, p, points, poses)
        weight = np.sqrt(views.visible * np.minimum(1.0, knee / np.maximum(distances, 1e-300)))
        J = (weight[..., None, None] * B).reshape(len(cost), -1, 6)
        r = (weight[..., None] * residuals).reshape(len(cost), -1, 1)
        V = J.transpose(0, 2, 1) @ J
        scale = np.sqrt(np.einsum("nii->ni", V))
        step = -np.linalg.solve(V / (scale[:, :, None] * scale[:, None]), J.transpose(0, 2, 1) @ r / scale[..., None])
        new_poses = poses.moved(step[..., 0] / scale)
        new_residuals = reprojection.reprojection_residuals(views, p, points, new_poses)
        new_distances = np.where(views.visible, np.linalg.norm(new_residuals, axis=2), 0.0)
        new_cost = reprojection.huber_loss(new_distances, knee).sum(axis=1)
        better = new_cost < cost
        poses = BoardPoses(
            np.where(better[:, None, None], new_poses.R, poses.R), np.where(better[:, None], new_poses.t, poses.t)
        )
        residuals = np.where(better[:, None, None], new_residuals, residuals)
        distances = np.where(better[:, None], new_distances, distances)
        cost = np.where(better, new_cost, cost)
    return distances


def fit_residuals(fitted: BundleFit, views: StackedViews) -> np.ndarray:
    """Predicted less observed corners of a fit, shape (n, c, 2), px; zero where not visible."""
    return reprojection.reprojection_residuals(views, fitted.parameters, fitted.shape.points, fitted.poses)


def fit_noise(fitted: BundleFit) -> float:
    """Standard deviation of a corner's coordinate in a fit, px, from the median distance, which bad corners do not change."""
    return max(float(np.median(fitted.distances[fitted.visible])) / np.sqrt(2 * np.log(2)), 1e-3)
