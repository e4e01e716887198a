"""Camera and board poses together, by least squares on the reprojection error: one routine serves every fit here.

Poses are eliminated by the Schur complement: with J = [A | B_1 .. B_n] the normal equations of the camera are
S = sum_i A_i' A_i - (A_i' B_i)(B_i' B_i)^-1 (B_i' A_i), whose inverse times the residual variance is the covariance.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from calibration import lens
from calibration.corners import BoardView

DEFAULT_FREE = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2")  # k3 only where cross-validation wants it


@dataclass(frozen=True)
class Poses:
    """T_camera_board of each view: p_camera = R p_board + t."""

    R: np.ndarray  # shape (n, 3, 3)
    t: np.ndarray  # shape (n, 3), m

    def of(self, index: np.ndarray | Sequence[int]) -> "Poses":
        """The poses of some of the views."""
        return Poses(self.R[index], self.t[index])


@dataclass(frozen=True)
class Fit:
    """The least squares of a set of views."""

    parameters: np.ndarray  # order of lens.NAMES, shape (9,)
    poses: Poses
    free: tuple[str, ...]
    rms_views: np.ndarray  # per view, px (over points: sqrt of the mean squared distance), shape (n,)
    rms: float  # px, over all points
    covariance: np.ndarray  # of the parameters for independent equal corner errors, shape (9, 9)
    converged: bool


def start(views: Sequence[BoardView], image_size: tuple[int, int]) -> tuple[np.ndarray, Poses]:
    """Parameters and poses close enough to iterate from: OpenCV's own calibration, k3 = 0.

    Raises cv2.error where OpenCV finds no start (views of lines, for example).
    """
    _, K, distortion, rvecs, tvecs = cv2.calibrateCamera(
        [view.object_points.astype(np.float32) for view in views],
        [view.image_points.astype(np.float32).reshape(-1, 1, 2) for view in views],
        image_size,
        np.zeros((3, 3)),
        np.zeros(5),
        flags=cv2.CALIB_FIX_K3,
    )
    parameters = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *np.ravel(distortion)[:5]])
    R = Rotation.from_rotvec(np.array(rvecs).reshape(-1, 3)).as_matrix()
    return parameters, Poses(R, np.array(tvecs).reshape(-1, 3))


def fit(
    views: Sequence[BoardView],
    parameters: np.ndarray,
    poses: Poses,
    free: Sequence[str] = DEFAULT_FREE,
    iterations: int = 50,
) -> Fit:
    """Levenberg-Marquardt from a start. What is not `free` keeps its value; with none free poses alone are fitted."""
    columns = np.array([lens.NAMES.index(name) for name in free], int)
    p = np.array(parameters, float)
    problem = _Problem(views)
    R, t = poses.R.copy(), poses.t.copy()
    residuals = problem.residuals(p, R, t)
    cost = float(np.sum(residuals**2))
    damping, converged = 1e-6, False
    for _ in range(iterations):
        A, B = problem.jacobians(p, R, t, columns)
        while damping < 1e6:
            step, pose_steps = _solve(problem, A, B, residuals, damping)
            p_new = p.copy()
            p_new[columns] += step
            R_new = Rotation.from_rotvec(pose_steps[:, :3]).as_matrix() @ R
            t_new = t + pose_steps[:, 3:]
            new = problem.residuals(p_new, R_new, t_new)
            new_cost = float(np.sum(new**2))
            if new_cost <= cost:  # also false for NaN
                break
            damping *= 10
        else:
            converged = True  # no step improves: as far as floating point goes
            break
        gain = cost - new_cost
        p, R, t, residuals, cost = p_new, R_new, t_new, new, new_cost
        damping = max(damping / 10, 1e-9)
        if gain <= 1e-10 * cost + 1e-18:
            converged = True
            break
    A, B = problem.jacobians(p, R, t, columns)
    covariance = np.zeros((9, 9))
    freedom = max(residuals.size - len(columns) - 6 * len(views), 1)
    if len(columns):
        S, _ = _reduced(problem, A, B, residuals, 0.0)
        scale = np.sqrt(np.maximum(np.diag(S), 1e-300))  # k and f differ by orders of magnitude
        covariance[np.ix_(columns, columns)] = np.linalg.pinv(S / np.outer(scale, scale), hermitian=True) / np.outer(
            scale, scale
        )
        covariance *= cost / freedom
    squared = np.sum(residuals.reshape(-1, 2) ** 2, axis=1)
    rms_views = np.sqrt(np.array([np.mean(squared[s]) for s in problem.slices]))
    return Fit(p, Poses(R, t), tuple(free), rms_views, float(np.sqrt(np.mean(squared))), covariance, converged)


class _Problem:
    """The points of all views in one array, so that residuals and Jacobians are vectorised."""

    def __init__(self, views: Sequence[BoardView]) -> None:
        self.points = np.concatenate([view.object_points for view in views])
        self.pixels = np.concatenate([view.image_points for view in views])
        counts = [len(view.image_points) for view in views]
        self.view_of = np.repeat(np.arange(len(views)), counts)
        ends = np.cumsum(counts)
        self.slices = [slice(end - count, end) for end, count in zip(ends, counts, strict=True)]

    def _seen(self, R: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Points in the camera frame without the translation, shape (n, 3), m."""
        return np.einsum("nij,nj->ni", R[self.view_of], self.points)

    def residuals(self, p: np.ndarray, R: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Predicted less seen, shape (2 n,), px; infinite where a point would lie behind the camera."""
        seen = self._seen(R, t) + t[self.view_of]
        if np.any(seen[:, 2] <= 0):
            return np.full(2 * len(seen), np.inf)
        return (lens.distort(seen[:, :2] / seen[:, 2:], p) - self.pixels).ravel()

    def jacobians(
        self, p: np.ndarray, R: np.ndarray, t: np.ndarray, columns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """By the free parameters, shape (2 n, m), and by the pose (rotation from the left, then t), shape (2 n, 6)."""
        turned = self._seen(R, t)
        seen = turned + t[self.view_of]
        x, y, depth = seen[:, 0], seen[:, 1], seen[:, 2]
        rays = seen[:, :2] / depth[:, None]
        by_point = np.zeros((len(seen), 2, 3))
        by_point[:, 0, 0] = by_point[:, 1, 1] = 1 / depth
        by_point[:, 0, 2], by_point[:, 1, 2] = -x / depth**2, -y / depth**2
        by_point = lens.ray_jacobian(rays, p) @ by_point
        # d(exp(w) q)/dw at w = 0 is -[q]x, so the row g of by_point gives (q x g)
        by_rotation = np.cross(turned[:, None, :], by_point)
        pose = np.concatenate([by_rotation, by_point], axis=2).reshape(-1, 6)
        return lens.parameter_jacobian(rays, p)[:, :, columns].reshape(2 * len(rays), len(columns)), pose


def _reduced(
    problem: _Problem, A: np.ndarray, B: np.ndarray, residuals: np.ndarray, damping: float
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """The camera's normal matrix with the poses eliminated, and (g, inverse V, W, h) to finish with."""
    U, g = A.T @ A, A.T @ residuals
    blocks = [(A[2 * s.start : 2 * s.stop], B[2 * s.start : 2 * s.stop]) for s in problem.slices]
    rest = [residuals[2 * s.start : 2 * s.stop] for s in problem.slices]
    V = np.stack([b.T @ b for _, b in blocks])
    W = np.stack([a.T @ b for a, b in blocks])
    h = np.stack([b.T @ r for (_, b), r in zip(blocks, rest, strict=True)])
    index = np.arange(6)
    V[:, index, index] *= 1 + damping
    U[np.diag_indices_from(U)] *= 1 + damping
    inverse = np.linalg.inv(V)
    S = U - np.einsum("nab,nbc,ndc->ad", W, inverse, W)
    return S, (g - np.einsum("nab,nbc,nc->a", W, inverse, h), inverse, W, h)


def _solve(
    problem: _Problem, A: np.ndarray, B: np.ndarray, residuals: np.ndarray, damping: float
) -> tuple[np.ndarray, np.ndarray]:
    """The damped Gauss-Newton step: of the free parameters, shape (m,), and of the poses, shape (n, 6)."""
    S, (g, inverse, W, h) = _reduced(problem, A, B, residuals, damping)
    step = np.zeros(len(g))
    if len(g):
        scale = np.sqrt(np.maximum(np.diag(S), 1e-300))
        step = -np.linalg.lstsq(S / np.outer(scale, scale), g / scale, rcond=None)[0] / scale
    poses = -np.einsum("nab,nb->na", inverse, h + np.einsum("nab,a->nb", W, step))
    return step, poses
