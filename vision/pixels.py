"""Which pixels of a picture tell where a marker is: those across its edges, side by side for all markers of a frame."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.planar_motion import homography, pixel_slopes
from vision.template import MARGIN, PIXEL_VARIANCE, Optics, Texture, texture

Array = NDArray[np.float64]

BLOCK = 8
"""px: compression works on blocks of this size from the picture's corner on"""
INSTANT = 1.5
"""px of motion to an instant of the exposure"""
STILL = 0.3
"""px; a motion below this is no blur"""


@dataclass(frozen=True)
class Pixels:
    """Pixels of M markers, padded to N a marker."""

    x: Array
    """(M, N), px"""
    y: Array
    grey: Array
    """(M, N), grey levels"""
    used: NDArray[np.bool_]
    """(M, N): neither padding nor clipped"""
    block: NDArray[np.intp]
    """(M, N): number of the compression block"""
    blocks: int
    inside: Array
    """(M,): share of the marker's square within the picture"""
    clipped: Array
    """(M,): share of pixels at 0 or 255"""
    contrast: Array
    """(M,): a first guess of white - black, grey levels"""
    textures: tuple[Texture, ...]
    instants: tuple[tuple[tuple[float, float], ...], ...]
    """for each marker, share and place (-1/2 .. 1/2) of the instants that stand for its exposure"""

    def only(self, k: int) -> "Pixels":
        """Marker k alone."""
        alone = slice(k, k + 1)
        return replace(self, x=self.x[alone], y=self.y[alone])

    def seen_from(self, G: Array) -> tuple[Array, Array]:
        """u and v, (M, N), through G (M, 3, 3), pixels to marker coordinates."""
        g = G[..., None]
        w = g[:, 2, 0] * self.x + g[:, 2, 1] * self.y + g[:, 2, 2]
        return (
            (g[:, 0, 0] * self.x + g[:, 0, 1] * self.y + g[:, 0, 2]) / w,
            (g[:, 1, 0] * self.x + g[:, 1, 1] * self.y + g[:, 1, 2]) / w,
        )


def select(
    grey: NDArray[np.uint8], cells: Sequence[NDArray[np.bool_]], corners: Array, motion: Array, optics: Optics
) -> Pixels:
    """Pixels for markers whose corners are at (M, 4, 2) px and move by `motion` (M, 4, 2) px during the exposure."""
    H = homography(corners)
    textures = tuple(_texture(c, h, optics) for c, h in zip(cells, H, strict=True))
    instants = tuple(_instants(float(np.linalg.norm(m, axis=1).max())) for m in motion)
    found = [_near_edges(grey, t, c, m, i) for t, c, m, i in zip(textures, corners, motion, instants, strict=True)]
    n = max(64, *(len(f[0]) for f in found))
    x, y = np.zeros((len(found), n)), np.zeros((len(found), n))
    level, used = np.zeros((len(found), n)), np.zeros((len(found), n), dtype=bool)
    block = np.zeros((len(found), n), dtype=np.intp)
    clipped, contrast, inside = np.zeros(len(found)), np.zeros(len(found)), np.zeros(len(found))
    blocks = 1
    for k, (px, py, share) in enumerate(found):
        inside[k] = share
        if len(px) < 64:
            continue
        at = slice(0, len(px))
        value = grey[py, px]
        limit = (value == 0) | (value == 255)
        x[k, at], y[k, at], level[k, at], used[k, at] = px, py, value, ~limit
        column, row = px // BLOCK, py // BLOCK
        column, row = column - column.min(), row - row.min()
        block[k, at] = row * (column.max() + 1) + column
        blocks = max(blocks, int(block[k].max()) + 1)
        clipped[k] = limit.mean()
        contrast[k] = 2.5 * value.std() + 1e-3
    return Pixels(x, y, level, used, block, blocks, inside, clipped, contrast, textures, instants)


def _texture(cells: NDArray[np.bool_], H: Array, optics: Optics) -> Texture:
    to_pixel = pixel_slopes(H[None], np.zeros((1, 2)))[0, 0] * 2 / len(cells)  # px per cell, (2, 2)
    sigma = float(np.sqrt(optics.sigma**2 + PIXEL_VARIANCE))
    blur = sigma * np.linalg.norm(np.linalg.inv(to_pixel), axis=1)
    return texture(cells, float(blur[0]), float(blur[1]), optics.bleed, sigma)


@lru_cache(maxsize=64)
def _gauss(n: int) -> tuple[tuple[float, float], ...]:
    places, shares = np.polynomial.legendre.leggauss(n)
    return tuple((float(s / 2), float(p / 2)) for s, p in zip(shares, places, strict=True))


def _instants(smear: float) -> tuple[tuple[float, float], ...]:
    """Gauss's nodes over the exposure for a motion of `smear` px."""
    return _gauss(1 if smear < STILL else 1 + int(np.ceil(smear / INSTANT)))


def _near_edges(
    grey: NDArray[np.uint8],
    texture: Texture,
    corners: Array,
    motion: Array,
    instants: tuple[tuple[float, float], ...],
) -> tuple[NDArray[np.intp], NDArray[np.intp], float]:
    """x and y of the pixels, and the share of the square that is in the picture."""
    ring = (1 + 2 * MARGIN / texture.cells) * (corners - corners.mean(axis=0)) + corners.mean(axis=0)
    low, high = np.floor(ring.min(axis=0)), np.ceil(ring.max(axis=0)) + 1
    height, width = grey.shape
    x0, y0 = (int(max(e, 0)) for e in low)
    x1, y1 = int(min(high[0], width)), int(min(high[1], height))
    nothing = np.zeros(0, dtype=np.intp)
    if not np.isfinite(ring).all() or x1 - x0 < 8 or y1 - y0 < 8:
        return nothing, nothing, 0.0
    places = np.array([place for _, place in instants])
    to_raster = texture.to_raster @ np.linalg.inv(homography(corners + places[:, None, None] * motion))
    to_raster = to_raster @ np.array([[1.0, 0.0, x0], [0.0, 1.0, y0], [0.0, 0.0, 1.0]])
    size, flags = (x1 - x0, y1 - y0), cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    seen = cv2.warpPerspective(texture.near_edges, to_raster[0], size, flags=flags)
    for place in to_raster[1:]:
        seen |= cv2.warpPerspective(texture.near_edges, place, size, flags=flags)
    row, column = np.nonzero(seen)
    share = (x1 - x0) * (y1 - y0) / float(np.prod(high - low))
    return column + x0, row + y0, share
