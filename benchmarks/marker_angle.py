"""The turn of a marker in the picture, which the benchmarks of corners compare."""

import numpy as np
from numpy.typing import NDArray

from vision.markers.planar_motion import CORNERS

Array = NDArray[np.float64]


def in_plane_angle(corners: Array) -> Array:
    """Turn of the marker, rad, (...), by the similarity nearest to corners (..., 4, 2); positive clockwise as seen."""
    z = (corners[..., 0] + 1j * corners[..., 1]) @ (CORNERS[:, 0] - 1j * CORNERS[:, 1])
    return np.angle(z)


def angle_slopes(corners: Array) -> Array:
    """(..., 8): derivatives of `in_plane_angle` by the corners, rad per px."""
    reference = CORNERS[:, 0] - 1j * CORNERS[:, 1]
    z = (corners[..., 0] + 1j * corners[..., 1]) @ reference
    turn = reference / z[..., None]
    return np.stack([turn.imag, turn.real], axis=-1).reshape(*z.shape, 8)
