"""Corners of a marker from the edges of its black square: four lines fitted to the grey levels, and where they meet.

A corner alone rests on a few pixels; a side rests on all pixels along it. The edge is placed where the profile across the side has
its centre of slope, which neither blur nor a constant light displaces.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ALONG = np.linspace(0.1, 0.9, 33)
"""where profiles are taken along a side, away from the corners, whose blur bends the edge"""
REACH = 0.5
"""half length of a profile in cells: inside black border and white margin"""
ACROSS = np.linspace(-1.0, 1.0, 17)
MIN_CONTRAST = 10.0
"""grey levels between both ends of a profile, below which it is left out"""
ROUNDS = 2


def refine(grey: NDArray[np.uint8], corners: Array, cells: int) -> Array:
    """Corners (4, 2), px, moved to the meeting points of the marker's sides.

    cells: black and white cells along a side of the marker, border included. A side with too few clear profiles, or
    corners that would move by more than a cell, leave the corners as they were.
    """
    start = corners
    cell = np.mean(np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)) / cells
    # three pixels serve a sharp edge; a reach of half a cell keeps the neighbouring cells out
    reach = min(max(1.5, REACH * cell), 4.0)
    for _ in range(ROUNDS):
        lines = _sides(grey, corners, reach)
        if lines is None:
            return start
        moved = np.array([np.cross(lines[k - 1], lines[k]) for k in range(4)])
        if np.any(np.abs(moved[:, 2]) < 1e-12):
            return start
        corners = moved[:, :2] / moved[:, 2:]
    return corners if np.max(np.abs(corners - start)) < cell else start


def _sides(grey: NDArray[np.uint8], corners: Array, reach: float) -> Array | None:
    """Lines a x + b y + c = 0 of the sides corner k to k + 1, shape (4, 3); None where one cannot be seen."""
    ends = np.roll(corners, -1, axis=0)
    along = ends - corners
    length = np.linalg.norm(along, axis=1, keepdims=True)
    # corners run clockwise in the picture (y down), so this points out of the square
    outward = np.column_stack([along[:, 1], -along[:, 0]]) / length
    foot = corners[:, None] + ALONG[:, None] * along[:, None]  # (4, A, 2)
    points = foot[:, :, None] + (reach * ACROSS)[:, None] * outward[:, None, None]  # (4, A, S, 2)
    x, y = np.moveaxis(points.reshape(4 * len(ALONG), len(ACROSS), 2).astype(np.float32), -1, 0)
    profile = cv2.remap(grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    profile = profile.astype(float).reshape(4, len(ALONG), len(ACROSS))
    slope = np.maximum(np.diff(profile, axis=-1), 0.0)  # darker inside, brighter outside
    contrast = profile[..., -1] - profile[..., 0]
    between = reach * (ACROSS[1:] + ACROSS[:-1]) / 2
    place = np.sum(slope * between, axis=-1) / np.maximum(np.sum(slope, axis=-1), 1e-9)
    lines = np.empty((4, 3))
    for k in range(4):
        clear = contrast[k] > max(MIN_CONTRAST, 0.5 * float(np.median(contrast[k])))
        if clear.sum() < len(ALONG) // 2:
            return None
        edge = foot[k] + place[k][:, None] * outward[k]
        lines[k] = _line(edge[clear])
    return lines


def _line(points: Array) -> Array:
    """Total least squares line through points (n, 2), once more without those that stray."""
    normal, middle = _through(points)
    off = np.abs((points - middle) @ normal)
    normal, middle = _through(points[off <= 3 * np.median(off) + 0.02])
    return np.array([*normal, -normal @ middle])


def _through(points: Array) -> tuple[Array, Array]:
    middle = points.mean(axis=0)
    return np.linalg.svd(points - middle, full_matrices=False)[2][1], middle
