"""How much the corners of a marker err together: its shift, turn, size and shape have each a standard deviation of their own.

Grey levels tell the corners' covariance as if small blocks of pixels erred by themselves. A codec predicts a block by shifting one
of another picture: whole markers are shifted, and a turn follows late and in parts, so that shift and turn err by more than shape.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.linkage.linkage_equations import whiten
from vision.linkage.observed_corners import Complex, ObservedCorners
from vision.linkage.standing_markers import standing_markers

Array = NDArray[np.float64]

MAX_SIGMA_RATIO = 10.0
"""standard deviation of a marker's corners in the worst direction over that in the best, above which all its errors are
scaled together: a little of the one would be many of the other (docs/thresholds.md)"""


@dataclass(frozen=True)
class ErrorComponents:
    """Factors on the standard deviations that are stated for the corners."""

    factor: Array
    """(2, 4): of the shift across the path, the turn, the size and the shape, which is what these leave; of markers that move,
    and of those that stand still. Along its path a marker errs half as across it and half as it turns: in parts, by motion"""
    standing: NDArray[np.bool_]
    """(markers,): which markers stand still in the picture"""
    path: Complex
    """(markers,): of length one, the direction in which each marker's path extends"""
    shared_shift: float = 0.0
    """variance in each direction, normalised coordinates, of a shift that all markers have in common but those of the base; sought
    where the camera shakes only"""

    @classmethod
    def as_stated(cls, image: Complex) -> "ErrorComponents":
        """Factors of one; image: corners of the recording, (F, markers, 4), NaN where not found."""
        return cls(np.ones((2, 4)), standing_markers(image), _path_directions(image))

    def whitened_errors(self, observed: ObservedCorners) -> Array:
        """Root of the covariance of whitened corners' errors, (F, markers, 8, 8): the unit matrix where all factors are one."""
        across, turn, size, shape = self.factor[self.standing.astype(int)].T
        beyond_shape = np.stack([(across + turn) / 2, across, turn, size], axis=-1) - shape[:, None]
        along = self.directions(observed.image)
        scale = np.einsum("fmki,mk,fmkj->fmij", along, beyond_shape, along) + shape[:, None, None] * np.eye(8)
        together = np.sqrt(np.sum(scale**2, axis=(2, 3), keepdims=True) / 8) * np.eye(8)
        each = observed.whitener @ scale @ observed.unwhitener
        return np.where(is_even(observed)[..., None, None], each, together)

    def directions(self, image: Complex) -> Array:
        """Unit vectors of x1, y1, x2, ... of markers with corners (F, markers, 4), at right angles, (F, markers, 4, 8).

        They shift a marker along its path and across it, turn it, and let it grow."""
        out = image - image.mean(axis=-1, keepdims=True)
        length = np.sqrt(np.sum(np.abs(out) ** 2, axis=-1, keepdims=True))
        out = out / np.where(length > 0, length, 1.0)
        shift = np.broadcast_to(self.path[:, None] / 2, image.shape)
        units = np.stack([shift, 1j * shift, 1j * out, out], axis=-2)
        return np.stack([units.real, units.imag], axis=-1).reshape(*units.shape[:-1], 8)


def is_even(observed: ObservedCorners) -> NDArray[np.bool_]:
    """Which markers were seen whole, and told about as well in all directions, (F, markers)."""
    return (observed.rank == 8) & (observed.sigma_ratio < MAX_SIGMA_RATIO)


def _path_directions(image: Complex) -> Complex:
    """Direction of the largest extent of each marker's path, (markers,), of corners (F, markers, 4), NaN where not found."""
    middle = image.mean(axis=2)
    known = ~np.isnan(middle)
    mean = np.where(known, middle, 0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    # twice the angle of the principal axis
    square = np.where(known, middle - mean, 0) ** 2
    return np.exp(0.5j * np.angle(square.sum(axis=0)))


def shared_shift_slopes(observed: ObservedCorners) -> Array:
    """Whitened corners by a shift of the whole picture along its rows and columns, (F, 8 markers, 2)."""
    return whiten(observed, np.broadcast_to(np.array([1.0, 1.0j]), (*observed.image.shape, 2)))
