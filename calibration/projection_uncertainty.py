"""Projection uncertainty: a camera's covariance as standard deviations of pixels and of what is measured through them.

The covariance of nine parameters says little by itself, since most of it changes no measurement: a rotated camera explains a
shifted optical axis, a more distant board a longer focal length. So the unknowns that are estimated through the camera are
refitted here, and only errors count that they do not absorb (as in mrcal's projection uncertainty). Two cases:

- directions: the camera's orientation alone is refitted, over the whole picture. Every body with a free pose absorbs at
  least that, so that this is an upper bound for all bodies (in the mean over the same points).
- a body: its unknowns (pose, joint angles) are refitted, and their covariance is the camera's effect on them.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calibration import lens
from calibration.camera import Camera


@dataclass(frozen=True)
class PropagatedUncertainty:
    """A camera's covariance propagated to points of a body and to the body's unknowns."""

    sigma: np.ndarray  # root mean square error of each point's pixel that the unknowns do not absorb, shape (n,), px
    covariance: np.ndarray  # of the unknowns, shape (m, m), in their own units


@dataclass(frozen=True)
class ProjectionSigma:
    """Standard deviation of projection over the picture, the orientation refitted; root mean square distances, px."""

    u: np.ndarray  # columns of the grid, px, shape (columns,)
    v: np.ndarray  # rows, px, shape (rows,)
    sigma: np.ndarray  # shape (rows, columns); NaN where the lens model has no inverse
    ninths: tuple[tuple[str, float], ...]  # name of each ninth of the picture and the largest sigma in it

    @cached_property
    def median(self) -> float:
        """Median over the picture, px."""
        return float(np.nanmedian(self.sigma))

    @cached_property
    def worst(self) -> float:
        """Largest value over the picture, px."""
        return float(np.nanmax(self.sigma))

    @property
    def worst_place(self) -> str:
        """Name of the ninth of the picture with the largest value."""
        return max(self.ninths, key=lambda ninth: ninth[1])[0]


def propagate_covariance(camera: Camera, rays: np.ndarray, by_unknowns: np.ndarray) -> PropagatedUncertainty:
    """The camera's covariance propagated to a body whose points lie along `rays`.

    rays: (x, y) of the body's points, shape (n, 2). by_unknowns: derivative of the rays by the body's unknowns, shape
    (n, 2, m), which are fitted to the pixels with equal weights. A camera without covariance is taken as exact.
    """
    p = camera.parameters
    shift = lens.parameter_jacobian(rays, p).reshape(-1, 9) @ covariance_root(camera)
    B = (lens.ray_jacobian(rays, p) @ by_unknowns).reshape(shift.shape[0], -1)
    scale = np.linalg.norm(B, axis=0)
    # predicted pixels shift; the unknowns change until they explain the observed pixels again
    change = np.linalg.lstsq(B / scale, -shift, rcond=None)[0] / scale[:, None]
    residual = shift + B @ change
    sigma = np.sqrt(np.sum(residual.reshape(len(rays), -1) ** 2, axis=1))
    return PropagatedUncertainty(sigma, change @ change.T)


def projection_sigma(camera: Camera, cells: tuple[int, int] = (32, 24)) -> ProjectionSigma:
    """Standard deviation of projection on a grid over the picture, `cells` across and down, the orientation refitted."""
    u, v = (np.linspace(0, side - 1, count) for side, count in zip(camera.size, cells, strict=True))
    rays = camera.rays(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    finite = np.all(np.isfinite(rays), axis=1)
    sigma = np.full(len(rays), np.nan)
    sigma[finite] = propagate_covariance(camera, rays[finite], rays_by_rotation(rays[finite])).sigma
    sigma = sigma.reshape(cells[1], cells[0])
    ninths = []
    for name, rows, columns in picture_ninths(cells[0], cells[1]):
        part = sigma[rows, columns]
        if np.any(np.isfinite(part)):
            ninths.append((name, float(np.nanmax(part))))
    return ProjectionSigma(u, v, sigma, tuple(ninths))


def picture_ninths(width: int, height: int) -> list[tuple[str, slice, slice]]:
    """The ninths of a picture of this size (in any unit): name, rows and columns."""
    columns = [slice(i * width // 3, (i + 1) * width // 3) for i in range(3)]
    rows = [slice(i * height // 3, (i + 1) * height // 3) for i in range(3)]
    return [
        (
            "middle" if r == c == 1 else f"{('upper', 'middle', 'lower')[r]} {('left', 'middle', 'right')[c]}",
            row,
            column,
        )
        for r, row in enumerate(rows)
        for c, column in enumerate(columns)
    ]


def covariance_root(camera: Camera) -> np.ndarray:
    """A matrix whose product with its transpose is the camera's covariance, shape (9, 9); zero where there is none."""
    if camera.covariance is None:
        return np.zeros((9, 9))
    scale = np.sqrt(np.diag(camera.covariance))  # k and f differ by orders of magnitude
    safe = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(camera.covariance / np.outer(safe, safe))
    return safe[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))


def rays_by_rotation(rays: np.ndarray) -> np.ndarray:
    """Derivative of rays (n, 2) by a small rotation (rotation vector, rad) of all of them, shape (n, 2, 3)."""
    x, y = rays[:, 0], rays[:, 1]
    return np.stack([np.stack([-x * y, 1 + x * x, -y], axis=-1), np.stack([-1 - y * y, x * y, x], axis=-1)], axis=1)


def rays_by_pose(points: np.ndarray) -> np.ndarray:
    """Derivative of the rays of points in the camera frame, (n, 3), m, by their body's pose, shape (n, 2, 6).

    The pose's unknowns: a small rotation about the camera (rad), then a translation in the camera frame (m).
    """
    rays = points[:, :2] / points[:, 2:]
    by_shift = np.zeros((len(points), 2, 3))
    by_shift[:, 0, 0] = by_shift[:, 1, 1] = 1 / points[:, 2]
    by_shift[:, :, 2] = -rays / points[:, 2:]
    return np.concatenate([rays_by_rotation(rays), by_shift], axis=2)


def board_information(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Fisher information of one view of a rigid board on the nine parameters, shape (9, 9), for corner noise of 1 px.

    points: the board's corners in the camera frame, shape (n, 3), m. The board's pose is eliminated: this is the Schur
    complement that the view adds to the normal equations of a calibration.
    """
    p = camera.parameters
    rays = points[:, :2] / points[:, 2:]
    A = lens.parameter_jacobian(rays, p).reshape(-1, 9)
    B = (lens.ray_jacobian(rays, p) @ rays_by_pose(points)).reshape(-1, 6)
    q = np.linalg.qr(B / np.linalg.norm(B, axis=0))[0]
    residual = A - q @ (q.T @ A)
    return residual.T @ residual
