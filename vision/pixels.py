"""Which pixels of a picture tell where a marker is: those across its edges, side by side for all markers of a frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.planar_motion import homography, pixel_slopes
from vision.template import MARGIN, PIXEL_VARIANCE, Optics, Texture, moving, texture

Array = NDArray[np.float64]

BLOCK = 8
"""px: compression works on blocks of this size from the picture's corner on"""


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
    excess: Array
    """(M,), px^2: by how much the textures' blur is wider than the optics', as blurs are rounded"""
    textures: tuple[Texture, ...]
    """with the motion during the exposure"""

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
    textures = tuple(_texture(c, h, m, optics) for c, h, m in zip(cells, H, motion, strict=True))
    excess = np.array([t.variance for t in textures]) - optics.sigma**2 - PIXEL_VARIANCE
    to_marker = np.linalg.inv(H)
    found = [_near_edges(grey, t, c, g) for t, c, g in zip(textures, corners, to_marker, strict=True)]
    n = max(64, *(len(f[0]) for f in found))
    x, y = np.zeros((len(found), n)), np.zeros((len(found), n))
    level, used = np.zeros((len(found), n)), np.zeros((len(found), n), dtype=bool)
    block = np.zeros((len(found), n), dtype=np.intp)
    clipped, inside = np.zeros(len(found)), np.zeros(len(found))
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
    return Pixels(x, y, level, used, block, blocks, inside, clipped, excess, textures)


def _texture(cells: NDArray[np.bool_], H: Array, motion: Array, optics: Optics) -> Texture:
    per_px = np.linalg.inv(pixel_slopes(H[None], np.zeros((1, 2)))[0, 0])  # marker coordinates per px, (2, 2)
    sigma = float(np.sqrt(optics.sigma**2 + PIXEL_VARIANCE))
    blur = sigma * np.linalg.norm(per_px, axis=1) * len(cells) / 2
    still = texture(cells, float(blur[0]), float(blur[1]), optics.bleed, sigma)
    mean = motion.mean(axis=0)
    return moving(still, per_px @ mean, float(np.linalg.norm(mean)))


def _near_edges(
    grey: NDArray[np.uint8], texture: Texture, corners: Array, to_marker: Array
) -> tuple[NDArray[np.intp], NDArray[np.intp], float]:
    """x and y of the pixels, and the share of the marker's surroundings that is in the picture."""
    middle = corners.mean(axis=0)
    ring = (1 + 2 * MARGIN / texture.cells) * (corners - middle) + middle
    nothing = np.zeros(0, dtype=np.intp)
    if not np.isfinite(ring).all():
        return nothing, nothing, 0.0
    low, high = np.floor(ring.min(axis=0)), np.ceil(ring.max(axis=0)) + 1
    height, width = grey.shape
    x0, y0 = (int(np.clip(e, 0, 1 << 20)) for e in low)
    x1, y1 = int(min(high[0], width)), int(min(high[1], height))
    if x1 - x0 < 8 or y1 - y0 < 8:
        return nothing, nothing, 0.0
    to_raster = texture.to_raster @ to_marker @ np.array([[1.0, 0.0, x0], [0.0, 1.0, y0], [0.0, 0.0, 1.0]])
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    seen = cv2.warpPerspective(texture.near_edges, to_raster, (x1 - x0, y1 - y0), flags=flags)
    row, column = np.nonzero(seen)
    return column + x0, row + y0, (x1 - x0) * (y1 - y0) / float(np.prod(high - low))
