"""Which pixels of a picture tell where a marker is: those across its edges, side by side for all markers of a frame."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.markers.planar_motion import homography, pixel_slopes
from vision.markers.template import MARGIN, PIXEL_VARIANCE, Optics, Texture, moving, texture, way_of

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

    def thinned(self, left: int) -> "Pixels":
        """About `left` of each marker's pixels."""
        every = max(1, self.used.shape[1] // left)
        some = slice(every // 2, None, every)
        place, grey, used = self.place[:, :, some], self.grey[:, some], self.used[:, some]
        return replace(self, place=np.ascontiguousarray(place), grey=grey, used=used)

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
    windows, inside = _windows(grey, textures, corners)
    to_marker = np.linalg.inv(H).astype(float)
    found = [
        _near_edges(grey, w, t, g, m) if w else NOTHING
        for w, t, g, m in zip(windows, textures, to_marker, way, strict=True)
    ]
    n = max(FEWEST, *(len(f.x) for f in found))
    place = np.ones((len(found), 3, n), dtype=np.float32)
    level, used = np.zeros((len(found), n), dtype=np.float32), np.zeros((len(found), n), dtype=bool)
    origin, clipped = np.zeros((len(found), 2)), np.zeros(len(found))
    for k, f in enumerate(found):
        count = len(f.x)
        if count >= FEWEST:
            place[k, 0, :count], place[k, 1, :count], origin[k] = f.x, f.y, f.origin
            level[k, :count] = f.grey
            np.less(f.grey - np.uint8(1), 254, out=used[k, :count])  # 0 - 1 is 255
            clipped[k] = 1 - np.count_nonzero(used[k]) / count
    return Pixels(place, origin, level, used, tuple(f.blocks for f in found), inside, clipped, excess, textures)


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


def _windows(
    grey: NDArray[np.uint8], textures: Sequence[Texture], corners: Array
) -> tuple[list[tuple[int, int, int, int] | None], Array]:
    """Whole blocks around each marker as x, y, width, height, None where it is outside; the share in the picture, (M,)."""
    middle = corners.mean(axis=1, keepdims=True)
    around = np.array([1 + 2 * MARGIN / t.cells for t in textures])[:, None, None]
    ring = around * (corners - middle) + middle
    low, high = np.floor(ring.min(axis=1)), np.ceil(ring.max(axis=1)) + 1
    whole = np.prod(high - low, axis=1)
    size = np.array(grey.shape[::-1], dtype=float)
    low, high = np.clip(low, 0, size), np.clip(high, 0, size)
    wide = np.all(high - low >= 8, axis=1)  # false for NaN
    share = np.where(wide, np.prod(high - low, axis=1) / whole, 0.0)
    windows: list[tuple[int, int, int, int] | None] = [None] * len(textures)
    for k in np.flatnonzero(wide):
        x0, y0 = (BLOCK * (int(e) // BLOCK) for e in low[k])
        x1, y1 = (BLOCK * -(-int(e) // BLOCK) for e in high[k])
        windows[k] = x0, y0, x1 - x0, y1 - y0
    return windows, share


@dataclass(frozen=True)
class _Found:
    """Pixels of one marker block by block: about the origin, and where blocks begin."""

    x: Single
    y: Single
    origin: tuple[int, int]
    grey: NDArray[np.uint8]
    blocks: NDArray[np.intp]


ONE_BLOCK = np.zeros(1, dtype=np.intp)
NOTHING = _Found(np.empty(0, np.float32), np.empty(0, np.float32), (0, 0), np.empty(0, np.uint8), ONE_BLOCK)


def _near_edges(
    grey: NDArray[np.uint8], window: tuple[int, int, int, int], texture: Texture, to_marker: Array, way: Array
) -> _Found:
    x0, y0, width, height = window
    to_raster = texture.to_raster @ to_marker
    to_raster[:, 2] += to_raster[:, :2] @ (x0, y0)
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    bits = np.asarray(cv2.warpPerspective(texture.near_edges, to_raster, (width, height), flags=flags), np.uint8)
    seen = bits & 1
    if texture.instants > 1:
        # an edge passes over the pixels on its way; what is outside stays so
        seen = np.asarray(cv2.dilate(seen, way_of(way, texture.instants)), np.uint8) & (bits >> 1)
    there = grey[y0 : y0 + height, x0 : x0 + width]
    if there.shape != seen.shape:  # a picture that is no whole number of blocks
        rows, columns = there.shape
        seen[rows:], seen[:, columns:] = 0, 0
        there = np.pad(there, ((0, height - rows), (0, width - columns)))
    at = np.flatnonzero(_by_block(seen).view(bool))
    if len(at) < FEWEST:
        return NOTHING
    x, y = _coordinates(width, height)
    block = at // BLOCK**2
    blocks = np.concatenate([ONE_BLOCK, np.flatnonzero(block[1:] != block[:-1]) + 1])
    return _Found(x[at], y[at], (x0, y0), _by_block(there)[at], blocks)


def _by_block(window: NDArray[Any]) -> NDArray[np.uint8]:
    """Pixels of whole blocks, (h w,), a block after the other."""
    h, w = window.shape
    return window.reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK).swapaxes(1, 2).ravel()


@lru_cache(maxsize=64)
def _coordinates(width: int, height: int) -> tuple[Single, Single]:
    """x and y of `_by_block`."""
    y, x = np.indices((height // BLOCK, width // BLOCK, BLOCK, BLOCK))[[0, 1]] * BLOCK
    inner = np.arange(BLOCK)
    return (x + inner).astype(np.float32).ravel(), (y + inner[:, None]).astype(np.float32).ravel()
