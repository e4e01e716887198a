"""Camera, board shape and board poses together, by least squares on the reprojection error: one routine serves every fit here.

Huber's loss on the distance of each corner keeps a single bad one from bending the camera.
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

DEFAULT_FREE_PARAMETERS = lens.LENS_MODELS["k1 k2 p1 p2"]


@dataclass(frozen=True)
class BundleFit:
    """The least squares of a set of views."""

    parameters: np.ndarray  # order of lens.NAMES, shape (9,)
    poses: BoardPoses
    free: tuple[str, ...]
    shape: BoardShape
    distances: np.ndarray  # predicted from seen, zero where not seen, shape (n, c), px
    knee: float  # px; infinite for plain least squares
    covariance: np.ndarray  # of the parameters for independent equal corner errors, shape (9, 9)
    shape_covariance: np.ndarray  # of shape.values, shape (3, 3)
    converged: bool
    seen: np.ndarray  # shape (n, c)
    normal: BundleEquations  # at the solution

    @property
    def rms(self) -> float:
        """px, over all corners."""
        return float(np.sqrt(np.sum(self.distances**2) / np.sum(self.seen)))

    @property
    def rms_views(self) -> np.ndarray:
        """Per view, px (over corners: sqrt of the mean squared distance), shape (n,)."""
        return np.sqrt(np.sum(self.distances**2, axis=1) / self.seen.sum(axis=1))

    @property
    def robust_rms_views(self) -> np.ndarray:
        """The same of Huber's loss, which single bad corners do not lift, shape (n,), px."""
        return np.sqrt(np.sum(reprojection.huber_loss(self.distances, self.knee), axis=1) / self.seen.sum(axis=1))


def initial_estimate(sightings: StackedViews, image_size: tuple[int, int]) -> tuple[np.ndarray, BoardPoses]:
    """Parameters and poses close enough to iterate from: focal length and poses from homographies, no distortion.

    Raises cv2.error where OpenCV finds no start (views of lines, for example).
    """
    objects = [sightings.nominal[seen].astype(np.float32) for seen in sightings.seen]
    images = [
        at[seen].astype(np.float32).reshape(-1, 1, 2) for at, seen in zip(sightings.pixels, sightings.seen, strict=True)
    ]
    K = cv2.initCameraMatrix2D(objects, images, image_size)
    found = [cv2.solvePnP(o, i, K, None, flags=cv2.SOLVEPNP_IPPE)[1:] for o, i in zip(objects, images, strict=True)]
    rvecs, tvecs = (np.array(part, float).reshape(-1, 3) for part in zip(*found, strict=True))
    parameters = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], 0.0, 0.0, 0.0, 0.0, 0.0])
    return parameters, BoardPoses(Rotation.from_rotvec(rvecs).as_matrix(), tvecs)


def fit_bundle(
    sightings: StackedViews,
    parameters: np.ndarray,
    poses: BoardPoses,
    free: Sequence[str] = DEFAULT_FREE_PARAMETERS,
    shape: BoardShape | None = None,
    shape_model: ShapeModel = board_shape.SHAPE_MODELS["rigid"],
    noise: float | None = None,
    iterations: int = 50,
) -> BundleFit:
    """Levenberg-Marquardt from a start. What is not `free` keeps its value; with none free poses alone are fitted.

    `noise` is the corners' standard deviation, px: it sets the knee of Huber's loss and the weight of what is believed of
    free offsets beforehand; without it plain least squares.
    """
    if shape_model.offsets and noise is None:
        raise ValueError("free offsets need the corners' noise")
    problem = BundleProblem(sightings, tuple(free), shape_model, noise)
    p = np.array(parameters, float)
    shape = replace(shape or flat_board(sightings.ids, sightings.nominal), model=shape_model)
    residuals = problem.residuals(p, shape.points, poses)
    cost = problem.cost(residuals, shape)
    damping, converged = 1e-6, False
    for _ in range(iterations):
        normal = problem.normal(p, shape, poses, residuals)
        while damping < 1e6:
            step, pose_steps = normal.step(damping)
            p_new, shape_new = problem.moved(p, shape, step)
            poses_new = poses.moved(pose_steps)
            new = problem.residuals(p_new, shape_new.points, poses_new)
            new_cost = problem.cost(new, shape_new)
            if new_cost <= cost:  # also false for NaN
                break
            damping *= 10
        else:
            converged = True  # no step improves: as far as floating point goes
            break
        gain = cost - new_cost
        p, shape, poses, residuals, cost = p_new, shape_new, poses_new, new, new_cost
        damping = max(damping / 10, 1e-9)
        if gain <= 1e-8 * cost + 1e-18:  # of 1000 corners: a few thousandths of a sigma
            converged = True
            break
    normal = problem.normal(p, shape, poses, residuals)
    distances = np.where(sightings.seen, np.linalg.norm(residuals, axis=2), 0.0)
    covariance, shape_covariance = problem.covariances(normal, distances)
    return BundleFit(
        p, poses, problem.free, shape, distances, problem.knee, covariance, shape_covariance, converged,
        sightings.seen, normal,
    )  # fmt: skip


def leave_out_groups(fitted: BundleFit, groups: Sequence[np.ndarray]) -> list[tuple[np.ndarray, BoardShape]]:
    """Parameters and board shape as they would be without the views of each group: one Gauss-Newton step from the whole.

    The step is of the order of sigma, where the problem is as good as linear; nothing is projected again.
    """
    found: list[tuple[np.ndarray, BoardShape]] = []
    for group in groups:
        step = fitted.normal.of(np.delete(np.arange(len(fitted.seen)), group)).step(0.0)[0]
        found.append(apply_step(fitted.parameters, fitted.shape, step, fitted.free))
    return found


def prediction_distances(
    sightings: StackedViews, parameters: np.ndarray, points: np.ndarray, poses: BoardPoses, knee: float = np.inf, steps: int = 4
) -> np.ndarray:
    """Distances of corners that each view's own camera (n, 9) and board (n, c, 3) leave, only the pose fitted; (n, c), px.

    All views at once, from poses that are nearly right; a view that a step would not improve keeps its pose.
    """
    p = parameters[:, None, :]
    residuals = reprojection.reprojection_residuals(sightings, p, points, poses)
    distances = np.where(sightings.seen, np.linalg.norm(residuals, axis=2), 0.0)
    cost = reprojection.huber_loss(distances, knee).sum(axis=1)
    for _ in range(steps):
        _, B = reprojection.pixel_jacobians(sightings, p, points, poses)
        weight = np.sqrt(sightings.seen * np.minimum(1.0, knee / np.maximum(distances, 1e-300)))
        J = (weight[..., None, None] * B).reshape(len(cost), -1, 6)
        r = (weight[..., None] * residuals).reshape(len(cost), -1, 1)
        V = J.transpose(0, 2, 1) @ J
        scale = np.sqrt(np.einsum("nii->ni", V))
        step = -np.linalg.solve(V / (scale[:, :, None] * scale[:, None]), J.transpose(0, 2, 1) @ r / scale[..., None])
        moved = poses.moved(step[..., 0] / scale)
        new = reprojection.reprojection_residuals(sightings, p, points, moved)
        new_distances = np.where(sightings.seen, np.linalg.norm(new, axis=2), 0.0)
        new_cost = reprojection.huber_loss(new_distances, knee).sum(axis=1)
        better = new_cost < cost
        poses = BoardPoses(np.where(better[:, None, None], moved.R, poses.R), np.where(better[:, None], moved.t, poses.t))
        residuals = np.where(better[:, None, None], new, residuals)
        distances = np.where(better[:, None], new_distances, distances)
        cost = np.where(better, new_cost, cost)
    return distances


def fit_residuals(fitted: BundleFit, sightings: StackedViews) -> np.ndarray:
    """Predicted less seen, shape (n, c, 2), px; zero where not seen."""
    return reprojection.reprojection_residuals(sightings, fitted.parameters, fitted.shape.points, fitted.poses)


def fit_noise(fitted: BundleFit) -> float:
    """Standard deviation of one coordinate, px, from the median distance, which bad corners do not move."""
    return max(float(np.median(fitted.distances[fitted.seen])) / np.sqrt(2 * np.log(2)), 1e-3)
