"""Corners as a camera would see them: residuals, their slopes by point and pose, and Huber's loss on their distances."""

import numpy as np

from calibration import lens
from calibration.board_poses import BoardPoses
from calibration.stacked_views import StackedViews


def huber_loss(distances: np.ndarray, knee: float) -> np.ndarray:
    """Huber's loss, the square up to the knee and then a line: px^2."""
    if np.isinf(knee):
        return distances**2
    return np.where(distances <= knee, distances**2, knee * (2 * distances - knee))


def corner_rays(sightings: StackedViews, points: np.ndarray, poses: BoardPoses) -> np.ndarray:
    """Corners on the plane z = 1 of the camera frame, shape (n, c, 2); those not seen need no depth."""
    at = points @ poses.R.transpose(0, 2, 1) + poses.t[:, None]
    return at[..., :2] / np.where(sightings.seen, at[..., 2], 1.0)[..., None]


def reprojection_residuals(sightings: StackedViews, p: np.ndarray, points: np.ndarray, poses: BoardPoses) -> np.ndarray:
    """Predicted less seen, shape (n, c, 2), px; infinite in views with a corner behind the camera, zero where not seen."""
    at = points @ poses.R.transpose(0, 2, 1) + poses.t[:, None]
    depth = np.where(sightings.seen, at[..., 2], 1.0)
    behind = np.any(depth <= 0, axis=1)
    depth = np.where(behind[:, None], 1.0, depth)
    missed = lens.rays_to_pixels(at[..., :2] / depth[..., None], p) - sightings.pixels
    missed[behind] = np.inf
    missed[~sightings.seen] = 0.0
    return missed


def pixel_jacobians(
    sightings: StackedViews, p: np.ndarray, points: np.ndarray, poses: BoardPoses
) -> tuple[np.ndarray, np.ndarray]:
    """Of the pixels, by the point in the camera frame, (n, c, 2, 3), and by the pose (rotation, then t), (n, c, 2, 6)."""
    turned = points @ poses.R.transpose(0, 2, 1)
    at = turned + poses.t[:, None]
    depth = np.where(sightings.seen, at[..., 2], 1.0)
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
