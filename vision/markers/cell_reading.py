"""What a picture shows of a marker's cells: whether they are as dark and bright as they should be, beside the white margin.

Middles of cells are read fast, for a marker that is known to be there. They cannot tell it from a marker of another dictionary with
more or fewer cells: dictionaries of few bits have an id for nearly all that is read. Whole cells can.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.markers.planar_motion import homography

Array = NDArray[np.float64]

MIN_CONTRAST_GREY = 10.0
"""grey levels between black and white cells, below which they are not read (docs/thresholds.md)"""
MAX_CONTRAST_RATIO = 3.0
"""of white cells and of the white margin, over black, either way: one paper in one light (docs/thresholds.md)"""

PLACES_IN_CELL = (np.arange(5) + 0.5) / 5
"""where the grey levels of a whole cell are taken, along both sides, 0..1"""


@dataclass(frozen=True)
class CellReading:
    """Of K markers."""

    right_share: Array
    """of the cells that are on the right side of the middle between black and white, (K,)"""
    contrast: Array
    """white cells over black ones, grey levels, (K,)"""
    margin_contrast: Array
    """the margin, half a cell outside, over black cells, (K,)"""

    @property
    def is_readable(self) -> NDArray[np.bool_]:
        """Whether there is anything to read, (K,)."""
        return self.contrast > MIN_CONTRAST_GREY

    @property
    def is_printed(self) -> NDArray[np.bool_]:
        """Whether white cells and margin stand out from black as one paper does, (K,): noise in a dark square does not."""
        alike = self.contrast < MAX_CONTRAST_RATIO * self.margin_contrast
        return self.is_readable & alike & (self.margin_contrast < MAX_CONTRAST_RATIO * self.contrast)


def read_cells(grey: NDArray[np.uint8], corners: Array, black: NDArray[np.bool_]) -> CellReading:
    """Of markers at these corners, (K, 4, 2), px, with these cells, (K, n, n), border included; read at the cells' middles."""
    n = black.shape[1]
    centre = (2 * np.arange(n) + 1) / n - 1  # marker coordinates, -1 to 1
    outside = np.repeat([-1 - 1 / n, 1 + 1 / n], n)
    beside = np.tile(centre, 2)
    u = np.concatenate([np.tile(centre, n), beside, outside])
    v = np.concatenate([np.repeat(centre, n), outside, beside])
    samples = _grey_levels(grey, corners, u, v)
    cells, margin = samples[:, : n * n], np.median(samples[:, n * n :], axis=1)
    flat = black.reshape(len(black), -1)
    count = np.count_nonzero(flat, axis=1)
    dark, every = np.einsum("kc,kc->k", cells, flat), cells.sum(axis=1)
    dark, bright = dark / count, (every - dark) / np.maximum(n * n - count, 1)
    threshold = ((dark + bright) / 2)[:, None]
    return CellReading(np.mean((cells < threshold) == flat, axis=1), bright - dark, margin - dark)


def dark_cells(grey: NDArray[np.uint8], corners: Array, n: int) -> NDArray[np.bool_]:
    """Which cells of squares at these corners, (K, 4, 2), px, are dark, (K, n, n), border included.

    A whole cell is nearer to the middle of the border's cells than to that of the margin around it."""
    side = 2 * (np.arange(-1, n + 1)[:, None] + PLACES_IN_CELL).ravel() / n - 1  # from a cell before to one behind
    samples = _grey_levels(grey, corners, np.tile(side, len(side)), np.repeat(side, len(side)), cv2.INTER_CUBIC)
    count = len(PLACES_IN_CELL)
    levels = samples.reshape(len(corners), n + 2, count, n + 2, count).mean(axis=(2, 4))
    margin, cells = _ring(levels), levels[:, 1:-1, 1:-1]
    middle = (np.median(margin, axis=1) + np.median(_ring(cells), axis=1)) / 2
    return cells < middle[:, None, None]


def _grey_levels(
    grey: NDArray[np.uint8], corners: Array, u: Array, v: Array, interpolation: int = cv2.INTER_LINEAR
) -> Array:
    """At places u, v (P,) in marker coordinates of markers at these corners, (K, 4, 2), px: (K, P)."""
    places = homography(corners) @ np.stack([u, v, np.ones_like(u)])
    x, y = ((places[:, axis] / places[:, 2]).astype(np.float32) for axis in range(2))
    return cv2.remap(grey, x, y, interpolation, borderMode=cv2.BORDER_REPLICATE).astype(float)


def _ring(cells: Array) -> Array:
    """The outermost of (K, n, n), (K, 4 n - 4)."""
    rows, columns = cells[:, [0, -1]], cells[:, 1:-1, [0, -1]]
    return np.concatenate([rows.reshape(len(cells), -1), columns.reshape(len(cells), -1)], axis=1)


def pattern_correlation(grey: NDArray[np.uint8], corners: Array, black: NDArray[np.bool_]) -> Array:
    """How well the grey levels in the whole cells inside of the border follow the pattern, -1 to 1, of K markers, (K,).

    Arguments as of `read_cells`. 0 where grey levels or pattern have no contrast.
    """
    n = black.shape[1]
    centre = 2 * (np.arange(1, n - 1)[:, None] + PLACES_IN_CELL).ravel() / n - 1  # marker coordinates, -1 to 1
    samples = _grey_levels(grey, corners, np.tile(centre, len(centre)), np.repeat(centre, len(centre)))
    count = len(PLACES_IN_CELL)
    white = (~black[:, 1:-1, 1:-1]).repeat(count, axis=1).repeat(count, axis=2).reshape(len(black), -1).astype(float)
    samples -= samples.mean(axis=1, keepdims=True)
    white -= white.mean(axis=1, keepdims=True)
    scale = np.linalg.norm(samples, axis=1) * np.linalg.norm(white, axis=1)
    return np.sum(samples * white, axis=1) / np.where(scale > 0, scale, np.inf)
