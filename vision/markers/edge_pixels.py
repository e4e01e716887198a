"""The pixels of a picture that tell where markers are: those across the edges of their cells."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.markers.planar_motion import pixel_slopes
from vision.markers.template import (
    MARGIN_CELLS,
    PIXEL_VARIANCE,
    Optics,
    Texture,
    marker_texture,
    motion_kernel,
    with_motion,
)

Array = NDArray[np.float64]
Single = NDArray[np.float32]

BLOCK_PX = 8
"""px: side of the blocks on which compression works, from the picture's corner on"""
MIN_PIXELS = 64
"""pixels across its edges below which a marker is given none"""


@dataclass(frozen=True)
class EdgePixels:
    """Pixels of M markers, padded to N a marker, in the order of the compression blocks."""

    points: Single
    """(M, 3, N): homogeneous coordinates relative to the marker's `origin`, px"""
    origin: Array
    """(M, 2), px"""
    grey: Single
    """(M, N), grey levels"""
    used: NDArray[np.bool_]
    """(M, N): neither padding nor clipped"""
    blocks: tuple[NDArray[np.intp], ...]
    """for each marker, the indices at which its compression blocks begin; the last block includes the padding"""
    share_inside: Array
    """(M,): share of the marker's square within the picture"""
    clipped_share: Array
    """(M,): share of pixels at 0 or 255"""
    excess_variance: Array
    """(M,), px^2: variance of the textures' blur above that of the optics, since blurs are rounded"""
    textures: tuple[Texture, ...]
    """of each marker, the motion during the exposure included"""
    tone: float
    """exponent of the camera's tone curve"""

    @property
    def xy(self) -> tuple[Single, Single]:
        """x and y relative to the origin, (M, N), px."""
        return self.points[:, 0], self.points[:, 1]

    def thinned(self, count: int) -> "EdgePixels":
        """About `count` of each marker's pixels, evenly spread."""
        every = max(1, self.used.shape[1] // count)
        kept = slice(every // 2, None, every)
        points, grey, used = self.points[:, :, kept], self.grey[:, kept], self.used[:, kept]
        return replace(self, points=np.ascontiguousarray(points), grey=grey, used=used)

    def marker_coordinates(self, G: Array) -> tuple[Single, Single]:
        """u and v, (M, N), by homographies G (M, 3, 3) from pixels to marker coordinates."""
        from_origin = G.copy()
        from_origin[:, :, 2] += (G[:, :, :2] @ self.origin[..., None])[..., 0]
        w: Single = np.matmul(from_origin.astype(np.float32), self.points)
        return w[:, 0] / w[:, 2], w[:, 1] / w[:, 2]


def select_pixels(
    grey: NDArray[np.uint8], cells: Sequence[NDArray[np.bool_]], corners: Array, H: Array, motion: Array, optics: Optics
) -> EdgePixels:
    """Pixels of markers with corners (M, 4, 2), px, that move by `motion` (M, 4, 2), px, during the exposure.

    H: (M, 3, 3), the `homography` of the corners.
    """
    shift = motion.mean(axis=1)
    textures = _textures(cells, H, shift, optics)
    excess_variance = np.array([t.variance for t in textures]) - optics.sigma**2 - PIXEL_VARIANCE
    windows, share_inside = _windows(grey, textures, corners)
    to_marker = np.linalg.inv(H).astype(float)
    selections = [
        _select(grey, w, t, g, m) if w else NO_PIXELS
        for w, t, g, m in zip(windows, textures, to_marker, shift, strict=True)
    ]
    n = max(MIN_PIXELS, *(len(f.x) for f in selections))
    markers = len(selections)
    points = np.ones((markers, 3, n), dtype=np.float32)
    level, used = np.zeros((markers, n), dtype=np.float32), np.zeros((markers, n), dtype=bool)
    origin, clipped = np.zeros((markers, 2)), np.zeros(markers)
    for k, f in enumerate(selections):
        count = len(f.x)
        if count >= MIN_PIXELS:
            points[k, 0, :count], points[k, 1, :count], origin[k] = f.x, f.y, f.origin
            level[k, :count] = f.grey
            np.less(f.grey - np.uint8(1), 254, out=used[k, :count])  # 0 - 1 is 255
            clipped[k] = 1 - np.count_nonzero(used[k]) / count
    return EdgePixels(
        points=points,
        origin=origin,
        grey=level,
        used=used,
        blocks=tuple(f.blocks for f in selections),
        share_inside=share_inside,
        clipped_share=clipped,
        excess_variance=excess_variance,
        textures=textures,
        tone=optics.tone,
    )


def _textures(cells: Sequence[NDArray[np.bool_]], H: Array, shift_px: Array, optics: Optics) -> tuple[Texture, ...]:
    """The texture of each marker as it appears under H (M, 3, 3) with a motion of shift_px (M, 2), px."""
    per_px = np.linalg.inv(pixel_slopes(H, np.zeros((1, 2)))[:, 0])  # marker coordinates per px, (M, 2, 2)
    sigma = float(np.sqrt(optics.sigma**2 + PIXEL_VARIANCE))
    blur = (sigma / 2 * np.linalg.norm(per_px, axis=2)).tolist()  # of the marker's half side, not yet of a cell
    shift = (per_px @ shift_px[..., None])[..., 0]
    smear = np.linalg.norm(shift_px, axis=1).tolist()
    return tuple(
        with_motion(marker_texture(c, len(c) * b[0], len(c) * b[1], optics.bleed, sigma), s, m)
        for c, b, s, m in zip(cells, blur, shift, smear, strict=True)
    )


def _windows(
    grey: NDArray[np.uint8], textures: Sequence[Texture], corners: Array
) -> tuple[list[tuple[int, int, int, int] | None], Array]:
    """Window of whole blocks around each marker (x, y, width, height; None outside the picture), and its share inside, (M,)."""
    middle = corners.mean(axis=1, keepdims=True)
    factor = np.array([1 + 2 * MARGIN_CELLS / t.cells for t in textures])[:, None, None]
    ring = factor * (corners - middle) + middle
    low, high = np.floor(ring.min(axis=1)), np.ceil(ring.max(axis=1)) + 1
    area = np.prod(high - low, axis=1)
    size = np.array(grey.shape[::-1], dtype=float)
    low, high = np.clip(low, 0, size), np.clip(high, 0, size)
    visible = np.all(high - low >= 8, axis=1)  # false for NaN
    share = np.where(visible, np.prod(high - low, axis=1) / area, 0.0)
    windows: list[tuple[int, int, int, int] | None] = [None] * len(textures)
    for k in np.flatnonzero(visible):
        x0, y0 = (BLOCK_PX * (int(e) // BLOCK_PX) for e in low[k])
        x1, y1 = (BLOCK_PX * -(-int(e) // BLOCK_PX) for e in high[k])
        windows[k] = x0, y0, x1 - x0, y1 - y0
    return windows, share


@dataclass(frozen=True)
class _Selection:
    """Pixels of one marker in the order of the blocks: coordinates relative to the origin, and where blocks begin."""

    x: Single
    y: Single
    origin: tuple[int, int]
    grey: NDArray[np.uint8]
    blocks: NDArray[np.intp]


ONE_BLOCK = np.zeros(1, dtype=np.intp)
NO_PIXELS = _Selection(np.empty(0, np.float32), np.empty(0, np.float32), (0, 0), np.empty(0, np.uint8), ONE_BLOCK)


def _select(
    grey: NDArray[np.uint8], window: tuple[int, int, int, int], texture: Texture, to_marker: Array, shift: Array
) -> _Selection:
    """Pixels of one window across the marker's edges, whatever its motion `shift` (2,), px, during the exposure."""
    x0, y0, width, height = window
    to_raster = texture.to_raster @ to_marker
    to_raster[:, 2] += to_raster[:, :2] @ (x0, y0)
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    bits = np.asarray(cv2.warpPerspective(texture.near_edges, to_raster, (width, height), flags=flags), np.uint8)
    near = bits & 1
    if texture.instants > 1:
        # a moving edge passes over more pixels, all of them inside the marker and its white ring
        near = np.asarray(cv2.dilate(near, motion_kernel(shift, texture.instants)), np.uint8) & (bits >> 1)
    window_grey = grey[y0 : y0 + height, x0 : x0 + width]
    if window_grey.shape != near.shape:  # a picture that is no whole number of blocks
        rows, columns = window_grey.shape
        near[rows:], near[:, columns:] = 0, 0
        window_grey = np.pad(window_grey, ((0, height - rows), (0, width - columns)))
    index = np.flatnonzero(_by_block(near).view(bool))
    if len(index) < MIN_PIXELS:
        return NO_PIXELS
    x, y = _coordinates(width, height)
    block = index // BLOCK_PX**2
    blocks = np.concatenate([ONE_BLOCK, np.flatnonzero(block[1:] != block[:-1]) + 1])
    return _Selection(x[index], y[index], (x0, y0), _by_block(window_grey)[index], blocks)


def _by_block(window: NDArray[Any]) -> NDArray[np.uint8]:
    """Pixels of a window of whole blocks, (h w,), block after block."""
    h, w = window.shape
    return window.reshape(h // BLOCK_PX, BLOCK_PX, w // BLOCK_PX, BLOCK_PX).swapaxes(1, 2).ravel()


@lru_cache(maxsize=64)
def _coordinates(width: int, height: int) -> tuple[Single, Single]:
    """x and y of the pixels in the order of `_by_block`."""
    y, x = np.indices((height // BLOCK_PX, width // BLOCK_PX, BLOCK_PX, BLOCK_PX))[[0, 1]] * BLOCK_PX
    inner = np.arange(BLOCK_PX)
    return (x + inner).astype(np.float32).ravel(), (y + inner[:, None]).astype(np.float32).ravel()
