"""Reprojection of board corners: residuals, their derivatives by point and pose, and Huber's loss of their distances."""

import numpy as np

from calibration import lens
from calibration.board_poses import BoardPoses
from calibration.stacked_views import StackedViews


def huber_loss(distances: np.ndarray, knee: float) -> np.ndarray:
    """Huber's loss, px^2: the square of the distance up to the knee, a line beyond it."""
    if np.isinf(knee):
        return distances**2
    return np.where(distances <= knee, distances**2, knee * (2 * distances - knee))


def corner_rays(views: StackedViews, points: np.ndarray, poses: BoardPoses) -> np.ndarray:
    """Corners on the plane z = 1 of the camera frame, shape (n, c, 2); corners that are not visible need no depth."""
    at = points @ poses.R.transpose(0, 2, 1) + poses.t[:, None]
    return at[..., :2] / np.where(views.visible, at[..., 2], 1.0)[..., None]


def reprojection_residuals(views: StackedViews, p: np.ndarray, points: np.ndarray, poses: BoardPoses) -> np.ndarray:
    """Predicted less observed corners, shape (n, c, 2), px; infinite in views with a corner behind the camera, zero where not
    visible."""
    at = points @ poses.R.transpose(0, 2, 1) + poses.t[:, None]
    depth = np.where(views.visible, at[..., 2], 1.0)
    behind = np.any(depth <= 0, axis=1)
    depth = np.where(behind[:, None], 1.0, depth)
    residuals = lens.rays_to_pixels(at[..., :2] / depth[..., None], p) - views.pixels
    residuals[behind] = np.inf
    residuals[~views.visible] = 0.0
    return residuals


def pixel_jacobians(
    views: StackedViews, p: np.ndarray, points: np.ndarray, poses: BoardPoses
) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of the pixels by the point in the camera frame, (n, c, 2, 3), and by the pose (rotation, t), (n, c, 2, 6)."""
    turned = points @ poses.R.transpose(0, 2, 1)
    at = turned + poses.t[:, None]
    depth = np.where(views.visible, at[..., 2], 1.0)
    ray = at[..., :2] / depth[..., None]
    by_ray = lens.ray_jacobian(ray, p) / depth[..., None, None]
    by_pose = np.empty((*depth.shape, 2, 6))
    by_point = by_pose[..., 3:]
    by_point[..., :2] = by_ray
    by_point[..., 2] = -(by_ray[..., 0] * ray[..., None, 0] + by_ray[..., 1] * ray[..., None, 1])
    # d(exp(w) q)/dw at w = 0 is -[q]x, so the row g of by_point gives (q x g)
    x, y, z = (turned[..., None, i] for i in range(3))
    by_pose[..., 0] = y * by_point[..., 2] - z * by_point[..., 1]
    by_pose[..., 1] = z * by_point[..., 0] - x * by_point[..., 2]
    by_pose[..., 2] = x * by_point[..., 1] - y * by_point[..., 0]
    return by_point, by_pose
