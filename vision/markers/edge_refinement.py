"""Corners of markers from the edges of their black squares: four lines fitted to the grey levels, and where they meet.

A corner alone rests on a few pixels; a side rests on all pixels along it. The edge is placed where the profile across the
side has its centre of slope, which neither blur nor a constant light displaces.
"""

from math import prod

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PROFILE_PLACES = np.linspace(0.1, 0.9, 33)
"""places of the profiles along a side, 0..1; away from the corners, whose blur bends the edge"""
PROFILE_SAMPLES = np.linspace(-1.0, 1.0, 17)
"""samples of a profile from inside to outside, in units of its half length"""
PROFILE_REACH_CELLS = 0.5
"""cells: half length of a profile, which stays inside the black border and the white margin"""
MIN_CONTRAST_GREY = 10.0
"""grey levels between both ends of a profile, below which it is not used (docs/thresholds.md)"""
ITERATIONS = 2


def refine_by_edges(grey: NDArray[np.uint8], corners: Array, cells: int) -> Array:
    """Corners of K markers, shape (K, 4, 2), px, moved to the meeting points of their sides.

    cells: black and white cells along a side of the marker, border included. NaN where a side has too few clear profiles, or
    corners would move by more than a cell: where they were is no measurement.
    """
    if not len(corners):
        return corners
    start, plausible = corners, np.ones(len(corners), dtype=bool)
    cell = np.mean(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2), axis=1) / cells
    # three pixels serve a sharp edge; a reach of half a cell keeps the neighbouring cells out
    reach = np.clip(PROFILE_REACH_CELLS * cell, 1.5, 4.0)
    for _ in range(ITERATIONS):
        lines = _sides(grey, corners, reach)
        meeting = np.cross(np.roll(lines, 1, axis=1), lines)
        depth = meeting[..., 2:]
        refined = meeting[..., :2] / np.where(np.abs(depth) > 1e-12, depth, np.nan)
        plausible = np.max(np.abs(refined - start), axis=(1, 2)) < cell  # false for NaN
        corners = np.where(plausible[:, None, None], refined, start)
    return np.where(plausible[:, None, None], corners, np.nan)


def _sides(grey: NDArray[np.uint8], corners: Array, reach: Array) -> Array:
    """Lines a x + b y + c = 0 of the sides from corner k to k + 1, shape (K, 4, 3); NaN where too few profiles are clear."""
    along = np.roll(corners, -1, axis=1) - corners
    # corners run clockwise in the picture (y down), so this points out of the square
    outward = np.stack([along[..., 1], -along[..., 0]], axis=-1)
    outward /= np.maximum(np.linalg.norm(outward, axis=-1, keepdims=True), 1e-9)
    foot = corners[:, :, None] + PROFILE_PLACES[:, None] * along[:, :, None]  # (K, 4, A, 2)
    across = reach[:, None] * PROFILE_SAMPLES  # (K, S)
    points = foot[:, :, :, None] + across[:, None, None, :, None] * outward[:, :, None, None]  # (K, 4, A, S, 2)
    # a row a marker: OpenCV takes no more than 32767 of either
    x, y = np.moveaxis(points.reshape(len(points), prod(points.shape[1:4]), 2).astype(np.float32), -1, 0)
    profile = cv2.remap(grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    profile = profile.astype(np.float32).reshape(points.shape[:-1])
    slope = np.maximum(np.diff(profile, axis=-1), 0.0)  # darker inside, brighter outside
    between = (across[:, 1:] + across[:, :-1]) / 2
    centre = np.einsum("kias,ks->kia", slope, between) / np.maximum(np.sum(slope, axis=-1), 1e-6)
    contrast = profile[..., -1] - profile[..., 0]
    clear = contrast > np.maximum(MIN_CONTRAST_GREY, 0.5 * np.median(contrast, axis=-1, keepdims=True))
    offset, tilt = _straight(centre, clear.astype(float))
    distance = np.abs(centre - offset[..., None] - tilt[..., None] * PROFILE_PLACES)
    near = clear & (distance <= 3 * np.median(distance, axis=-1, keepdims=True) + 0.02)
    offset, tilt = _straight(centre, near.astype(float))
    ends = corners + offset[..., None] * outward, corners + along + (offset + tilt)[..., None] * outward
    first, last = (np.concatenate([end, np.ones((*end.shape[:-1], 1))], axis=-1) for end in ends)
    lines = np.cross(first, last)
    return np.where((clear.sum(axis=-1) >= len(PROFILE_PLACES) // 2)[..., None], lines, np.nan)


def _straight(place: Array, weight: Array) -> tuple[Array, Array]:
    """Weighted fit of the straight line place = offset + tilt ALONG on the last axis."""
    total = np.maximum(weight.sum(axis=-1), 1e-9)
    middle, mean = (weight @ PROFILE_PLACES) / total, np.sum(weight * place, axis=-1) / total
    from_middle = PROFILE_PLACES - middle[..., None]
    spread = np.maximum(np.sum(weight * from_middle**2, axis=-1), 1e-9)
    tilt = np.sum(weight * from_middle * place, axis=-1) / spread
    return mean - tilt * middle, tilt
