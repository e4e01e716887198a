"""Corners of markers with what is known of their noise, made ready for least squares."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration import lens
from calibration.camera import Camera

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

PORTION = 500
"""frames at once, so that memory does not grow with the recording"""


@dataclass(frozen=True)
class Observed:
    """Corners of F frames."""

    image: Complex
    """(F, markers, 4): normalised coordinates x + jy, zero where not seen"""
    seen: NDArray[np.bool_]
    """(F, markers)"""
    whitener: Array
    """(F, markers, 8, 8): turns differences of normalised coordinates x1, y1, x2, ... into numbers of one common variance"""
    sigma: Array
    """(F, markers, 4): standard deviation of each corner in normalised coordinates, in the same measure"""
    rank: NDArray[np.intp]
    """(F, markers): how many independent numbers an observation is worth; zero where not seen"""


def normalise(camera: Camera, corners: Array) -> Complex:
    """Corners (F, markers, 4, 2), px as detected, as normalised coordinates, NaN where not seen."""
    image = np.empty(corners.shape[:-1], dtype=complex)
    for start in range(0, len(corners), PORTION):
        part = corners[start : start + PORTION]
        rays = camera.rays(np.nan_to_num(part.reshape(-1, 2)))
        image[start : start + PORTION] = (rays[:, 0] + 1j * rays[:, 1]).reshape(part.shape[:-1])
    image[np.isnan(corners).any(axis=(-2, -1)) | np.isnan(image).any(axis=-1)] = np.nan
    return image


def observed(camera: Camera, image: Complex, covariance: Array | None) -> Observed:
    """Normalised corners (F, markers, 4) with the covariance of their pixels, (F, markers, 8, 8), px^2.

    Without a covariance (None, or NaN for single markers) corners are independent and alike, 1 px. A direction
    of zero variance carries no information: that is how a refinement of fewer than eight degrees of freedom states its.
    """
    seen = np.asarray(~np.isnan(image).any(axis=-1))
    image = np.where(seen[..., None], image, 0)
    rays = np.stack([image.real, image.imag], axis=-1).reshape(-1, 2)
    slope = lens.ray_jacobian(rays, camera.parameters).reshape(*image.shape, 2, 2)
    blocks = np.zeros((*image.shape[:2], 8, 8))
    for c in range(4):
        blocks[..., 2 * c : 2 * c + 2, 2 * c : 2 * c + 2] = slope[:, :, c]
    scale = np.sqrt(np.abs(np.linalg.det(slope)))
    if covariance is None:
        whitener, sigma_px, rank = blocks, np.ones(image.shape), np.full(seen.shape, 8)
    else:
        known = np.asarray(np.isfinite(covariance).all(axis=(-2, -1)))[..., None, None]
        w, v = np.linalg.eigh(np.where(known, covariance, np.eye(8)))
        live = w > 1e-9 * w[..., -1:]
        root = np.where(live, 1 / np.sqrt(np.where(live, w, 1.0)), 0.0)
        whitener = root[..., None] * np.swapaxes(v, -1, -2) @ blocks
        spread = np.diagonal(np.where(known, covariance, np.eye(8)), axis1=-2, axis2=-1)
        of_corner = spread.reshape(*image.shape, 2).mean(axis=-1)
        of_marker = spread.mean(axis=-1, keepdims=True)
        # a corner of zero variance does not enter; it only must not divide by zero
        sigma_px = np.sqrt(np.where(of_corner > 0, of_corner, np.where(of_marker > 0, of_marker, 1.0)))
        rank = live.sum(axis=-1)
    return Observed(
        image=image,
        seen=seen,
        whitener=whitener * seen[..., None, None],
        sigma=sigma_px / scale,
        rank=np.where(seen, rank, 0),
    )
