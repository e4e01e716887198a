"""What the lens does to a marker beyond a homography: it bows the edges, and a corner fitted to bowed edges is off.

Both refinements fit straight things, the square's sides or the whole marker through a homography. At 60 px, with a lens
of k1 = -0.12, an edge bows by up to 0.04 px and the marker comes out 0.015 px away from the picture's middle or towards it: as
long as the marker stays there, so that more frames do not average it out. The fit is repeated here with points along
the edges instead of pixels, and what it errs by is taken off.
"""

import numpy as np
from numpy.typing import NDArray

from calibration import lens
from calibration.camera import Camera
from vision.linkage.observed_corners import PORTION
from vision.markers.planar_motion import corner_slopes, displacement, homography, pixel_slopes, project

Array = NDArray[np.float64]

SIDE = np.linspace(-0.8, 0.8, 9)
"""points along a side: the part of it that `edges` looks at"""


def straightened(camera: Camera, corners: Array, cells: NDArray[np.bool_] | None) -> Array:
    """Corners (F, markers, 4, 2), px, NaN where not found, without what bowed edges did to them.

    cells: (markers, n, n), True is black, where all edges of the cells were fitted; None for the sides of the square alone.
    """
    out = corners.copy()
    for k in range(corners.shape[1]):
        points, along = _sides() if cells is None else _cell_edges(cells[k])
        seen = np.flatnonzero(~np.isnan(corners[:, k]).any(axis=(1, 2)))
        for start in range(0, len(seen), PORTION):
            frames = seen[start : start + PORTION]
            out[frames, k] -= _displaced(camera, corners[frames, k], points, along)
    return out


def _displaced(camera: Camera, corners: Array, points: Array, along: Array) -> Array:
    """By how much (M, 4, 2), px, the bow of edges at `points` (n, 2) that run `along` (n, 2) displaces corners (M, 4, 2)."""
    rays = camera.rays(corners.reshape(-1, 2)).reshape(corners.shape)
    on_rays = project(homography(rays), np.broadcast_to(points, (len(corners), *points.shape)))
    H = homography(corners)
    straight = project(H, np.broadcast_to(points, (len(corners), *points.shape)))
    bow = lens.distort(on_rays.reshape(-1, 2), camera.parameters).reshape(straight.shape) - straight
    slopes = pixel_slopes(H, points)
    course = np.einsum("mnij,nj->mni", slopes, along)
    across = np.stack([course[..., 1], -course[..., 0]], axis=-1)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    # only what is across an edge shows
    rows = np.einsum("mni,mnij,jkn->mnk", across, slopes, np.array(displacement(*points.T)), optimize=True)
    seen = np.sum(across * bow, axis=-1)
    rows_T = np.swapaxes(rows, 1, 2)
    xi = np.linalg.solve(rows_T @ rows, rows_T @ seen[..., None])
    displaced = (corner_slopes(H) @ xi).reshape(corners.shape)
    return np.where(np.isfinite(displaced), displaced, 0.0)


def _sides() -> tuple[Array, Array]:
    """Points on the square's four sides and the directions of the sides there, marker coordinates, (n, 2) each."""
    one, zero = np.ones_like(SIDE), np.zeros_like(SIDE)
    level = [np.column_stack([SIDE, end * one]) for end in (-1, 1)]
    upright = [np.column_stack([end * one, SIDE]) for end in (-1, 1)]
    points = np.concatenate(level + upright)
    return points, np.concatenate([np.column_stack(way) for way in 2 * [(one, zero)] + 2 * [(zero, one)]])


def _cell_edges(cells: NDArray[np.bool_]) -> tuple[Array, Array]:
    """The same for all borders between black and white: the middles of the cells' sides."""
    n = len(cells)
    black = np.pad(cells, 1)
    row, column = np.nonzero(black[1:] != black[:-1])  # borders below these cells, which run along u
    level = np.column_stack([2 * column - n - 1, 2 * row - n]) / n
    down, right = np.nonzero(black[:, 1:] != black[:, :-1])
    upright = np.column_stack([2 * right - n, 2 * down - n - 1]) / n
    ways = [np.tile([1.0, 0.0], (len(level), 1)), np.tile([0.0, 1.0], (len(upright), 1))]
    return np.concatenate([level, upright]), np.concatenate(ways)
