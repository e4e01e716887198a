"""Which pixels of a picture tell where a marker is: those across its edges, side by side for all markers of a frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.planar_motion import homography, pixel_slopes
from vision.template import MARGIN, PIXEL_VARIANCE, Optics, Texture, moving, texture, way_of

Array = NDArray[np.float64]
Single = NDArray[np.float32]

BLOCK = 8
"""px: compression works on blocks of this size from the picture's corner on"""
FEWEST = 64
"""pixels, below which a marker has none"""


@dataclass(frozen=True)
class Pixels:
    """Pixels of M markers, padded to N a marker, block by block."""

    place: Single
    """(M, 3, N): homogeneous coordinates about the marker's `origin`, px"""
    origin: Array
    """(M, 2), px"""
    grey: Single
    """(M, N), grey levels"""
    used: NDArray[np.bool_]
    """(M, N): neither padding nor clipped"""
    blocks: tuple[NDArray[np.intp], ...]
    """of each marker, where its compression blocks begin; the last one goes on into the padding"""
    inside: Array
    """(M,): share of the marker's square within the picture"""
    clipped: Array
    """(M,): share of pixels at 0 or 255"""
    excess: Array
    """(M,), px^2: by how much the textures' blur is wider than the optics', as blurs are rounded"""
    textures: tuple[Texture, ...]
    """with the motion during the exposure"""

    @property
    def at(self) -> tuple[Single, Single]:
        """x and y about the origin, (M, N), px."""
        return self.place[:, 0], self.place[:, 1]

    def seen_from(self, G: Array) -> tuple[Single, Single]:
        """u and v, (M, N), through G (M, 3, 3), pixels to marker coordinates."""
        about = G.copy()
        about[:, :, 2] += (G[:, :, :2] @ self.origin[..., None])[..., 0]
        w: Single = np.matmul(about.astype(np.float32), self.place)
        return w[:, 0] / w[:, 2], w[:, 1] / w[:, 2]


def select(
    grey: NDArray[np.uint8], cells: Sequence[NDArray[np.bool_]], corners: Array, motion: Array, optics: Optics
) -> Pixels:
    """Pixels for markers whose corners are at (M, 4, 2) px and move by `motion` (M, 4, 2) px during the exposure."""
    H = homography(corners)
    way = motion.mean(axis=1)
    textures = _textures(cells, H, way, optics)
    excess = np.array([t.variance for t in textures]) - optics.sigma**2 - PIXEL_VARIANCE
    found, inside = _near_edges(grey, textures, corners, np.linalg.inv(H).astype(float), way)
    n = max(FEWEST, *(len(f) for f in found))
    place = np.ones((len(found), 3, n), dtype=np.float32)
    level, used = np.zeros((len(found), n), dtype=np.float32), np.zeros((len(found), n), dtype=bool)
    origin, clipped = np.zeros((len(found), 2)), np.zeros(len(found))
    blocks = []
    for k, at in enumerate(found):
        if len(at) < FEWEST:
            blocks.append(np.zeros(1, dtype=np.intp))
            continue
        first = at.min(axis=0)
        column, row = ((at // BLOCK) - first // BLOCK).T
        block = (row * (int(column.max()) + 1) + column).astype(np.uint16)
        order = np.argsort(block, kind="stable")
        at, block = at[order], block[order]
        count = len(at)
        value = grey[at[:, 1], at[:, 0]]
        limit = (value == 0) | (value == 255)
        place[k, :2, :count], origin[k] = (at - first).T, first
        level[k, :count], used[k, :count] = value, ~limit
        blocks.append(np.concatenate([[0], np.flatnonzero(block[1:] != block[:-1]) + 1]))
        clipped[k] = np.count_nonzero(limit) / count
    return Pixels(place, origin, level, used, tuple(blocks), inside, clipped, excess, textures)


def _textures(cells: Sequence[NDArray[np.bool_]], H: Array, way: Array, optics: Optics) -> tuple[Texture, ...]:
    per_px = np.linalg.inv(pixel_slopes(H, np.zeros((1, 2)))[:, 0])  # marker coordinates per px, (M, 2, 2)
    sigma = float(np.sqrt(optics.sigma**2 + PIXEL_VARIANCE))
    blur = (sigma / 2 * np.linalg.norm(per_px, axis=2)).tolist()  # of the marker's half side, not yet of a cell
    shift = (per_px @ way[..., None])[..., 0]
    smear = np.linalg.norm(way, axis=1).tolist()
    return tuple(
        moving(texture(c, len(c) * b[0], len(c) * b[1], optics.bleed, sigma), s, m)
        for c, b, s, m in zip(cells, blur, shift, smear, strict=True)
    )


def _near_edges(
    grey: NDArray[np.uint8], textures: Sequence[Texture], corners: Array, to_marker: Array, way: Array
) -> tuple[list[NDArray[np.int32]], Array]:
    """x and y of each marker's pixels, (n, 2), and the share of its surroundings that is in the picture, (M,)."""
    middle = corners.mean(axis=1, keepdims=True)
    around = np.array([1 + 2 * MARGIN / t.cells for t in textures])[:, None, None]
    ring = around * (corners - middle) + middle
    low, high = np.floor(ring.min(axis=1)), np.ceil(ring.max(axis=1)) + 1
    size = np.array(grey.shape[::-1], dtype=float)
    whole = np.prod(high - low, axis=1)
    low, high = np.clip(low, 0, size), np.clip(high, 0, size)
    wide = np.all(high - low >= 8, axis=1)  # false for NaN
    to_raster = np.stack([t.to_raster for t in textures]) @ to_marker
    to_raster[:, :, 2] += (to_raster[:, :, :2] @ np.nan_to_num(low)[..., None])[..., 0]
    found = []
    for k, t in enumerate(textures):
        if not wide[k]:
            found.append(np.zeros((0, 2), dtype=np.int32))
            continue
        x0, y0, x1, y1 = (int(e) for e in (*low[k], *high[k]))
        flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
        bits = np.asarray(cv2.warpPerspective(t.near_edges, to_raster[k], (x1 - x0, y1 - y0), flags=flags), np.uint8)
        seen = bits & 1
        if t.instants > 1:
            # an edge passes over the pixels on its way; what is outside stays so
            seen = np.asarray(cv2.dilate(seen, way_of(way[k], t.instants)), np.uint8) & (bits >> 1)
        at = np.asarray(cv2.findNonZero(seen) if seen.any() else np.zeros((0, 2)), dtype=np.int32)
        found.append(at.reshape(-1, 2) + np.array([x0, y0], dtype=np.int32))
    share = np.where(wide, np.prod(high - low, axis=1) / whole, 0.0)
    return found, share
