"""Printed patterns of square cells, and what each pixel of a camera gets of them: the mean over the pixel's area.

This is what makes markers and boards exact. Nothing is warped from one raster to another; every pixel is carried back
into the pattern, where the mean of a box over piecewise constant cells is known in closed form. The box is centred on
the pixel, so edges are blurred but never moved.
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

PAPER = 0.86
"""reflectance of white"""
INK = 0.045
"""reflectance of black"""

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Pattern:
    """Square cells on paper, in OpenCV's frame of boards: origin at the top left of the cells, x right, y down, m."""

    cells: FloatArray
    """reflectance, shape (rows, columns)"""
    cell: float
    """side of a cell, m"""
    paper: tuple[float, float]
    """width of the blank paper left and right of the cells, and above and below, m"""

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the cells, m."""
        return self.cells.shape[1] * self.cell, self.cells.shape[0] * self.cell

    def sheet(self) -> FloatArray:
        """Corners of the whole sheet of paper, clockwise from the top left, shape (4, 2), m."""
        (w, h), (a, b) = self.extent, self.paper
        return np.array([[-a, -b], [w + a, -b], [w + a, h + b], [-a, h + b]])


def seen(pattern: Pattern, xy: FloatArray, samples: int = 2) -> tuple[FloatArray, FloatArray]:
    """Mean reflectance over each pixel, and the share of the pixel that the sheet covers; both of shape (h, w).

    `xy`: where the pixels' centres meet the pattern, shape (h, w, 2), m. Each pixel is cut into samples x samples.
    """
    dv, du = np.gradient(xy, axis=(0, 1))
    # the box along an axis that has the variance of the part's parallelogram: exact for edges up to the third moment
    width = np.hypot(du, dv) / samples
    value = np.zeros(xy.shape[:2])
    cover = np.zeros(xy.shape[:2])
    parts = (np.arange(samples) + 0.5) / samples - 0.5
    for a in parts:
        for b in parts:
            at = xy + a * du + b * dv
            value += _box_mean(pattern, at, width)
            cover += _box_cover(pattern, at, width)
    return value / samples**2, cover / samples**2


def _box_mean(pattern: Pattern, at: FloatArray, width: FloatArray) -> FloatArray:
    rows, columns = pattern.cells.shape
    padded = np.pad(pattern.cells, 2, constant_values=PAPER).ravel()
    size = np.minimum(width / pattern.cell, 1.0)  # a box touches at most two cells: patterns are meant to be resolved
    low = at / pattern.cell - size / 2
    first = np.floor(low)
    share = np.minimum((first + 1 - low) / size, 1.0)
    i = np.clip(first[..., 0].astype(np.intp) + 2, 0, columns + 2)
    j = np.clip(first[..., 1].astype(np.intp) + 2, 0, rows + 2)
    k = j * (columns + 4) + i
    sx, sy = share[..., 0], share[..., 1]
    above = padded[k] * sx + padded[k + 1] * (1 - sx)
    below = padded[k + columns + 4] * sx + padded[k + columns + 5] * (1 - sx)
    return above * sy + below * (1 - sy)


def _box_cover(pattern: Pattern, at: FloatArray, width: FloatArray) -> FloatArray:
    corners = pattern.sheet()
    middle, half = (corners[0] + corners[2]) / 2, (corners[2] - corners[0]) / 2
    inside = np.clip((half - np.abs(at - middle)) / width + 0.5, 0.0, 1.0)
    return inside[..., 0] * inside[..., 1]


def dictionary(name: str) -> Any:
    """OpenCV's predefined dictionary of the name used in files: `apriltag_36h11`, `aruco_5x5_100`, ..."""
    constant = "DICT_" + name.upper().removeprefix("ARUCO_")
    code = getattr(cv2.aruco, constant, None)
    if code is None:
        known = sorted(n for n in dir(cv2.aruco) if n.startswith("DICT_"))
        raise ValueError(f"dictionary {name}: OpenCV has no {constant}; it has {', '.join(known)}")
    return cv2.aruco.getPredefinedDictionary(code)


@lru_cache(maxsize=256)
def marker_pattern(name: str, number: int, size: float, quiet: float = 1.1) -> Pattern:
    """A marker of black side `size`, m, upright as OpenCV draws it, on a plate with `quiet` cells of white around."""
    bits = _marker_cells(name, number)
    cell = size / bits.shape[0]
    return Pattern(bits, cell, (quiet * cell, quiet * cell))


def charuco_pattern(board: dict[str, Any], paper: float = 0.015) -> Pattern:
    """A ChArUco board: black square at the top left, markers on the white squares in order of rows."""
    columns, rows = int(board["columns"]), int(board["rows"])
    bits = _marker_cells(board["dictionary"], 0).shape[0]
    unit, per_bit, per_square = _common_unit(board["square"], board["marker"], bits)
    margin = (per_square - per_bit * bits) // 2
    cells = np.full((rows * per_square, columns * per_square), PAPER)
    number = 0
    for row in range(rows):
        for column in range(columns):
            square = cells[row * per_square :, column * per_square :][:per_square, :per_square]
            if (row + column) % 2 == 0:
                square[:] = INK
            else:
                bitmap = np.kron(_marker_cells(board["dictionary"], number), np.ones((per_bit, per_bit)))
                square[margin : per_square - margin, margin : per_square - margin] = bitmap
                number += 1
    return Pattern(cells, unit, (paper, paper))


def _marker_cells(name: str, number: int) -> FloatArray:
    """Reflectance of the cells of a marker with its black border, shape (bits + 2, bits + 2)."""
    words = dictionary(name)
    side = words.markerSize + 2
    return np.where(cv2.aruco.generateImageMarker(words, number, side, borderBits=1) > 127, PAPER, INK)


def _common_unit(square: float, marker: float, bits: int) -> tuple[float, int, int]:
    """The longest length, m, of which a marker's bit, a square and a marker's margin are all whole multiples."""
    bit = Fraction(str(marker)) / bits
    margin = (Fraction(str(square)) - Fraction(str(marker))) / 2
    unit = _common(bit, margin)
    return float(unit), int(bit / unit), int(Fraction(str(square)) / unit)


def _common(a: Fraction, b: Fraction) -> Fraction:
    """Greatest common divisor of two fractions, by Euclid."""
    while b:
        a, b = b, a % b
    return a
