"""Detected corners of markers, normalised and whitened by their covariance for least squares."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibration import lens
from calibration.camera import Camera

Array = NDArray[np.float64]
Floats = NDArray[np.floating]
"""of single or double precision"""
Complex = NDArray[np.complex128]

CHUNK_FRAMES = 500
"""frames that are worked on at once, so that memory does not grow with the recording"""


@dataclass(frozen=True)
class ObservedCorners:
    """Corners of F frames with the whitening of their noise."""

    image: Complex
    """(F, markers, 4): normalised coordinates x + jy, zero where not visible"""
    visible: NDArray[np.bool_]
    """(F, markers): whether the marker was found in the frame"""
    whitener: Array
    """(F, markers, 8, 8): maps differences of normalised coordinates x1, y1, x2, ... to numbers of one common variance"""
    sigma: Array
    """(F, markers, 4): standard deviation of each corner, normalised coordinates, up to that common variance"""
    rank: NDArray[np.intp]
    """(F, markers): number of independent coordinates of a marker; zero where not visible"""

    @cached_property
    def unwhitener(self) -> Array:
        """Inverse of the whitener, (F, markers, 8, 8); the unit matrix where a marker was not seen whole."""
        whole = (self.rank == 8)[..., None, None]
        return np.linalg.inv(np.where(whole, self.whitener, np.eye(8)))

    @cached_property
    def sigma_ratio(self) -> Array:
        """Standard deviation of a marker's corners in the worst direction over that in the best, (F, markers); 1 where it was not
        seen whole."""
        return np.linalg.cond(self.unwhitener)

    def of(self, frames: NDArray[np.intp]) -> "ObservedCorners":
        """Those of some frames."""
        return ObservedCorners(
            self.image[frames], self.visible[frames], self.whitener[frames], self.sigma[frames], self.rank[frames]
        )


def normalise_corners(camera: Camera, corners: Array) -> Complex:
    """Corners (F, markers, 4, 2), px as detected, as normalised coordinates, NaN where not found."""
    image = np.empty(corners.shape[:-1], dtype=complex)
    for start in range(0, len(corners), CHUNK_FRAMES):
        part = corners[start : start + CHUNK_FRAMES]
        rays = camera.rays(np.nan_to_num(part.reshape(-1, 2)))
        image[start : start + CHUNK_FRAMES] = (rays[:, 0] + 1j * rays[:, 1]).reshape(part.shape[:-1])
    image[np.isnan(corners).any(axis=(-2, -1)) | np.isnan(image).any(axis=-1)] = complex(np.nan, np.nan)
    return image


def whiten_corners(camera: Camera, image: Complex, covariance: Floats | None) -> ObservedCorners:
    """Normalised corners (F, markers, 4) with the whitening by the covariance of their pixels, (F, markers, 8, 8), px^2.

    Without a covariance (None, or NaN for single markers) corners count as independent with 1 px each. A direction of zero
    variance carries no information: that is how a refinement of fewer than eight degrees of freedom states its covariance.
    """
    visible = np.asarray(~np.isnan(image).any(axis=-1))
    image = np.where(visible[..., None], image, 0)
    rays = np.stack([image.real, image.imag], axis=-1).reshape(-1, 2)
    slope = lens.ray_jacobian(rays, camera.parameters).reshape(*image.shape, 2, 2)
    blocks = np.zeros((*image.shape[:2], 8, 8))
    for c in range(4):
        blocks[..., 2 * c : 2 * c + 2, 2 * c : 2 * c + 2] = slope[:, :, c]
    scale = np.sqrt(np.abs(np.linalg.det(slope)))
    if covariance is None:
        whitener, sigma_px, rank = blocks, np.ones(image.shape), np.full(visible.shape, 8)
    else:
        known = np.asarray(np.isfinite(covariance).all(axis=(-2, -1)))[..., None, None]
        w, v = np.linalg.eigh(np.where(known, covariance, np.eye(8)))
        informed = w > 1e-9 * w[..., -1:]
        root = np.where(informed, 1 / np.sqrt(np.where(informed, w, 1.0)), 0.0)
        whitener = root[..., None] * np.swapaxes(v, -1, -2) @ blocks
        spread = np.diagonal(np.where(known, covariance, np.eye(8)), axis1=-2, axis2=-1)
        of_corner = spread.reshape(*image.shape, 2).mean(axis=-1)
        of_marker = spread.mean(axis=-1, keepdims=True)
        # a corner of zero variance does not count, but must not divide by zero
        sigma_px = np.sqrt(np.where(of_corner > 0, of_corner, np.where(of_marker > 0, of_marker, 1.0)))
        rank = informed.sum(axis=-1)
    return ObservedCorners(
        image=image,
        visible=visible,
        whitener=whitener * visible[..., None, None],
        sigma=sigma_px / scale,
        rank=np.where(visible, rank, 0),
    )
