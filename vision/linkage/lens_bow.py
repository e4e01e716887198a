"""Correction of corners for the bow of a marker's edges, which the lens adds to a homography.

Both refinements fit straight shapes, the square's sides or the whole marker through a homography. At 60 px, with a lens of
k1 = -0.12, an edge bows by up to 0.04 px and the marker comes out 0.015 px off along the radius of the picture. The error
lasts while the marker stays there, so that more frames do not average it out. The fit is repeated here with points along the
edges instead of pixels, and its error is subtracted.
"""

import numpy as np
from numpy.typing import NDArray

from calibration import lens
from calibration.camera import Camera
from vision.linkage.observed_corners import CHUNK_FRAMES
from vision.markers.planar_motion import apply_homography, corner_slopes, homography, pixel_slopes, unit_displacements

Array = NDArray[np.float64]

SIDE_POINTS = np.linspace(-0.8, 0.8, 9)
"""points along a side, -1..1: the part of it that `edge_refinement` uses"""


def correct_lens_bow(camera: Camera, corners: Array, cells: NDArray[np.bool_] | None) -> Array:
    """Corners (F, markers, 4, 2), px, NaN where not found, without the displacement that the bow of their edges caused.

    cells: (markers, n, n), True is black, where all edges of the cells were fitted; None where the square's sides were.
    """
    corrected = corners.copy()
    for k in range(corners.shape[1]):
        points, along = _sides() if cells is None else _cell_edges(cells[k])
        found = np.flatnonzero(~np.isnan(corners[:, k]).any(axis=(1, 2)))
        for start in range(0, len(found), CHUNK_FRAMES):
            frames = found[start : start + CHUNK_FRAMES]
            corrected[frames, k] -= _displaced(camera, corners[frames, k], points, along)
    return corrected


def _displaced(camera: Camera, corners: Array, points: Array, along: Array) -> Array:
    """Displacement (M, 4, 2), px, of fitted corners (M, 4, 2) by the bow of edges at `points` (n, 2) that run `along` (n, 2)."""
    rays = camera.rays(corners.reshape(-1, 2)).reshape(corners.shape)
    on_rays = apply_homography(homography(rays), np.broadcast_to(points, (len(corners), *points.shape)))
    H = homography(corners)
    straight = apply_homography(H, np.broadcast_to(points, (len(corners), *points.shape)))
    bow = lens.rays_to_pixels(on_rays.reshape(-1, 2), camera.parameters).reshape(straight.shape) - straight
    slopes = pixel_slopes(H, points)
    direction = np.einsum("mnij,nj->mni", slopes, along)
    across = np.stack([direction[..., 1], -direction[..., 0]], axis=-1)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    # an edge shows only the part of the bow across it
    rows = np.einsum("mni,mnij,jkn->mnk", across, slopes, np.array(unit_displacements(*points.T)), optimize=True)
    bow_across = np.sum(across * bow, axis=-1)
    rows_T = np.swapaxes(rows, 1, 2)
    xi = np.linalg.solve(rows_T @ rows, rows_T @ bow_across[..., None])
    displaced = (corner_slopes(H) @ xi).reshape(corners.shape)
    return np.where(np.isfinite(displaced), displaced, 0.0)


def _sides() -> tuple[Array, Array]:
    """Points on the square's four sides and the directions of the sides there, marker coordinates, (n, 2) each."""
    one, zero = np.ones_like(SIDE_POINTS), np.zeros_like(SIDE_POINTS)
    level = [np.column_stack([SIDE_POINTS, end * one]) for end in (-1, 1)]
    upright = [np.column_stack([end * one, SIDE_POINTS]) for end in (-1, 1)]
    points = np.concatenate(level + upright)
    return points, np.concatenate([np.column_stack(direction) for direction in 2 * [(one, zero)] + 2 * [(zero, one)]])


def _cell_edges(cells: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Middles of all cell sides between black and white and the directions of these sides, marker coordinates, (n, 2) each."""
    n = len(cells)
    black = np.pad(cells, 1)
    row, column = np.nonzero(black[1:] != black[:-1])  # borders below these cells, which run along u
    level = np.column_stack([2 * column - n - 1, 2 * row - n]) / n
    down, right = np.nonzero(black[:, 1:] != black[:, :-1])
    upright = np.column_stack([2 * right - n, 2 * down - n - 1]) / n
    directions = [np.tile([1.0, 0.0], (len(level), 1)), np.tile([0.0, 1.0], (len(upright), 1))]
    return np.concatenate([level, upright]), np.concatenate(directions)
