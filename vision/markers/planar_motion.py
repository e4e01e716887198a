"""How a marker moves in the picture: the homography that its four corners define, and small motions about it.

A small motion has eight numbers xi: a shift, a linear map, and the two perspective terms u (u, v) and v (u, v) of the marker's
point (u, v). These motions span the tangent space of the homographies, so that the motion of the corners determines xi.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""corners of the black square in marker coordinates, in OpenCV's order"""
TO_UNIT_SQUARE = np.array([[0.5, 0.0, 0.5], [0.0, 0.5, 0.5], [0.0, 0.0, 1.0]])
"""from marker coordinates to those in which the corners are 0 and 1"""
DOF = 8
"""numbers of a small motion"""


def unit_displacements(u: Array, v: Array) -> tuple[list[Array], list[Array]]:
    """Displacements along u and v for a unit of each of the DOF motions, two lists of arrays shaped like u and v."""
    one, zero = np.ones_like(u), np.zeros_like(u)
    return [one, zero, u, v, zero, zero, u * u, u * v], [zero, one, zero, zero, u, v, u * v, v * v]


CORNER_DISPLACEMENTS = np.stack([np.column_stack(part) for part in unit_displacements(*CORNERS.T)], axis=1)
"""(4, 2, DOF): displacements of the corners for a unit of each motion"""


def homography(corners: Array) -> Array:
    """(M, 3, 3): homographies from marker coordinates to pixels, for corners (M, 4, 2), px; Heckbert's closed form."""
    p0, p1, p2, p3 = (corners[:, k] for k in range(4))
    d1, d2, s = p1 - p2, p3 - p2, p0 - p1 + p2 - p3
    det = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]
    det = np.where(np.abs(det) > 1e-9, det, 1e-9)  # corners on a line: no marker, but no division by zero either
    g = (s[:, 0] * d2[:, 1] - s[:, 1] * d2[:, 0]) / det
    h = (d1[:, 0] * s[:, 1] - d1[:, 1] * s[:, 0]) / det
    H = np.empty((len(corners), 3, 3))
    H[:, :2, 0] = p1 - p0 + g[:, None] * p1
    H[:, :2, 1] = p3 - p0 + h[:, None] * p3
    H[:, :2, 2] = p0
    H[:, 2, 0], H[:, 2, 1], H[:, 2, 2] = g, h, 1.0
    return H @ TO_UNIT_SQUARE


def apply_homography(H: Array, points: Array) -> Array:
    """Points (M, n, 2) mapped by H (M, 3, 3)."""
    x = points @ np.swapaxes(H[:, :2, :2], 1, 2) + H[:, None, :2, 2]
    return x / (points @ np.swapaxes(H[:, 2:, :2], 1, 2) + H[:, None, 2:, 2])


def move_corners(H: Array, xi: Array) -> Array:
    """Corners (M, 4, 2), px, that the homographies H give after the motions xi (M, DOF)."""
    return apply_homography(H, CORNERS + np.einsum("kaj,mj->mka", CORNER_DISPLACEMENTS, xi))


def corner_slopes(H: Array) -> Array:
    """(M, 8, DOF): derivatives of the corners (x, y of the first, ...), px, by the motion."""
    return (pixel_slopes(H, CORNERS) @ CORNER_DISPLACEMENTS).reshape(len(H), 8, DOF)


def pixel_slopes(H: Array, points: Array) -> Array:
    """(M, n, 2, 2): derivatives of the pixel by u and v at the marker's points (n, 2)."""
    x = apply_homography(H, np.broadcast_to(points, (len(H), *points.shape)))
    w = points @ np.swapaxes(H[:, 2:, :2], 1, 2) + H[:, None, 2:, 2]
    return (H[:, None, :2, :2] - x[..., None] * H[:, None, 2:, :2]) / w[..., None]
