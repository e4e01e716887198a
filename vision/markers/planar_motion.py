"""How a marker moves in the picture: the homography that its four corners fix, and small motions about it.

A small motion displaces the point m = (u, v) of the marker by xi(m), eight numbers: a shift, a linear map, and the two
perspective terms u (u, v) and v (u, v). It is tangent to all homographies, so the corners' motion says it all.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""of the black square in marker coordinates, in OpenCV's order"""
DOF = 8


def displacement(u: Array, v: Array) -> tuple[list[Array], list[Array]]:
    """Displacements along u and v, both lists of DOF, for a unit of each motion, at points of any shape."""
    one, zero = np.ones_like(u), np.zeros_like(u)
    return [one, zero, u, v, zero, zero, u * u, u * v], [zero, one, zero, zero, u, v, u * v, v * v]


AT_CORNERS = np.stack([np.column_stack(part) for part in displacement(*CORNERS.T)], axis=1)
"""(4, 2, DOF): the corners' displacements"""


def homography(corners: Array) -> Array:
    """(M, 3, 3): marker coordinates to pixels, for corners of shape (M, 4, 2), px; Heckbert's closed form."""
    p0, p1, p2, p3 = np.moveaxis(corners, 1, 0)
    d1, d2, s = p1 - p2, p3 - p2, p0 - p1 + p2 - p3
    det = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]
    det = np.where(np.abs(det) > 1e-9, det, 1e-9)  # corners on a line: no marker, but no division by zero either
    g = (s[:, 0] * d2[:, 1] - s[:, 1] * d2[:, 0]) / det
    h = (d1[:, 0] * s[:, 1] - d1[:, 1] * s[:, 0]) / det
    H = np.empty((len(corners), 3, 3))
    H[:, :2, 0] = p1 - p0 + g[:, None] * p1
    H[:, :2, 1] = p3 - p0 + h[:, None] * p3
    H[:, :2, 2] = p0
    H[:, 2] = np.column_stack([g, h, np.ones(len(g))])
    return H @ np.array([[0.5, 0.0, 0.5], [0.0, 0.5, 0.5], [0.0, 0.0, 1.0]])


def project(H: Array, points: Array) -> Array:
    """Points of shape (M, n, 2) through H (M, 3, 3)."""
    x = points @ np.swapaxes(H[:, :2, :2], 1, 2) + H[:, None, :2, 2]
    return x / (points @ np.swapaxes(H[:, 2:, :2], 1, 2) + H[:, None, 2:, 2])


def moved(H: Array, xi: Array) -> Array:
    """Corners (M, 4, 2), px, after the motions xi (M, DOF)."""
    return project(H, CORNERS + np.einsum("kaj,mj->mka", AT_CORNERS, xi))


def corner_slopes(H: Array) -> Array:
    """(M, 8, DOF): derivatives of the corners (x, y of the first, ...), px, by the motion."""
    return (pixel_slopes(H, CORNERS) @ AT_CORNERS).reshape(len(H), 8, DOF)


def pixel_slopes(H: Array, points: Array) -> Array:
    """(M, n, 2, 2): derivatives of the pixel by u and v at the marker's points (n, 2)."""
    x = project(H, np.broadcast_to(points, (len(H), *points.shape)))
    w = points @ np.swapaxes(H[:, 2:, :2], 1, 2) + H[:, None, 2:, 2]
    return (H[:, None, :2, :2] - x[..., None] * H[:, None, 2:, :2]) / w[..., None]


def in_plane_angle(corners: Array) -> Array:
    """Turn of the marker in the picture, rad, (...): the similarity nearest to corners (..., 4, 2); positive clockwise as seen."""
    z = (corners[..., 0] + 1j * corners[..., 1]) @ (CORNERS[:, 0] - 1j * CORNERS[:, 1])
    return np.angle(z)


def angle_slopes(corners: Array) -> Array:
    """(..., 8): derivatives of `in_plane_angle` by the corners, rad per px."""
    reference = CORNERS[:, 0] - 1j * CORNERS[:, 1]
    z = (corners[..., 0] + 1j * corners[..., 1]) @ reference
    turn = reference / z[..., None]
    return np.stack([turn.imag, turn.real], axis=-1).reshape(*z.shape, 8)
