"""Cables as taut strings on the arm: the piece of every route word, whole cables, and a fast table for simulating.

A piece runs from the lowest point of its entry wheel to its end, or to the lowest point of its exit wheel, where the
next piece begins; "lowest" is meant in the frame of the bar that carries the wheel.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from samples.generator.linkage import solve
from samples.generator.taut_string import Array, Complex, TautString, Wheel, outline, tighten

# Corner, sense of winding, and what the string winds there, roughly (it picks the whole turns). A wheel that is passed
# on the outside carries a full turn in total: three quarters belong to the piece below it, a quarter to the one above.
_RIGHT, _LEFT = +1, -1
_WAY: dict[str, tuple[tuple[str, int, float], ...]] = {
    "right": (("bottom right", _RIGHT, pi), ("top right", 0, 0.0)),
    "left": (("bottom left", _LEFT, pi), ("top left", 0, 0.0)),
    "right_through": (("bottom right", _RIGHT, pi), ("top right", _RIGHT, 1.5 * pi)),
    "left_through": (("bottom left", _LEFT, pi), ("top left", _LEFT, 1.5 * pi)),
    "strut": (("bottom right", _RIGHT, pi), ("top left", _LEFT, pi), ("top right", _RIGHT, 0.0)),
    "strut_mirrored": (("bottom left", _LEFT, pi), ("top right", _RIGHT, pi), ("top left", _LEFT, 0.0)),
}
WORDS = tuple(_WAY)


@dataclass(frozen=True)
class Piece:
    """A cable's portion in one mechanism, seen from its bottom bar's middle; leading shape (...) is that of alpha."""

    string: TautString
    start: Complex
    """direction of travel at the lowest point of the entry wheel, shape ()"""
    slope: Array
    """dlength/dalpha from the contact geometry, shape (...), m"""

    @property
    def length(self) -> Array:
        """shape (...), m"""
        return self.string.length

    def outline(self) -> Complex:
        """Points for drawing (alpha must be one angle), shape (P,), m, in the bottom bar's frame."""
        return outline(self.string, complex(self.start))


def piece(word: str, alpha: Array, L: float, b: float, r: float) -> Piece:
    """The piece of a route word at angles alpha, shape (...), rad; L, b, r in m."""
    alpha = np.asarray(alpha, dtype=float)
    bars = solve(alpha[..., None], np.array([L]), np.array([b]))
    corners = {
        "bottom left": bars.left[..., 0],
        "bottom right": bars.right[..., 0],
        "top left": bars.left[..., 1],
        "top right": bars.right[..., 1],
    }
    way = _WAY[word]
    wheels = [Wheel(corners[corner], r if sense else 0.0, sense, about) for corner, sense, about in way]
    # at the lowest point of a wheel the string runs along the bar, to the right where it goes round counter-clockwise
    start = np.array(way[0][1], dtype=complex)
    exit_sense = way[-1][1]
    string = tighten(wheels, start, exit_sense * np.exp(1j * alpha) if exit_sense else None)

    # The top bar turns, for the moment, about the point where the diagonals cross. A taut string gains length only
    # where a span is pulled along itself, and where the mark on the exit wheel turns with its bar.
    cross = _crossing(corners["bottom left"], corners["top right"], corners["bottom right"], corners["top left"])
    by_alpha = [1j * (corners[c] - cross) if c.startswith("top") else np.zeros_like(cross) for c, _, _ in way]
    stretch = np.diff(np.stack(by_alpha, axis=-1), axis=-1)
    slope = np.sum((string.directions.conj() * stretch).real, axis=-1) + exit_sense * r
    return Piece(string, start, slope)


def _crossing(a: Complex, b: Complex, c: Complex, d: Complex) -> Complex:
    """Where the lines a-b and c-d meet, m."""

    def cross(u: Complex, v: Complex) -> Array:
        return (u.conj() * v).imag

    return a + (b - a) * cross(c - a, d - c) / cross(b - a, d - c)


def lengths(neck: dict[str, Any], alpha: Array) -> Array:
    """Lengths of the cables from the base's wheels on, shape (..., M), m; alpha of shape (..., N), rad."""
    m = neck["mechanisms"]
    return np.stack(
        [
            sum(piece(w, alpha[..., i], m[i]["L"], m[i]["b"], m[i]["r"]).length for i, w in enumerate(cable["route"]))
            for cable in neck["cables"]
        ],
        axis=-1,
    )


def wrap_table(neck: dict[str, Any], reach: float = 1.2, nodes: int = 601) -> Callable[[Array], Array]:
    """alpha (T, N), rad -> the angle that each cable is wound around wheels, (T, M), rad; straight lines between nodes."""
    grid = np.linspace(-reach, reach, nodes)
    m = neck["mechanisms"]
    tables = {
        (i, word): piece(word, grid, m[i]["L"], m[i]["b"], m[i]["r"]).string.wound.sum(axis=-1)
        for cable in neck["cables"]
        for i, word in enumerate(cable["route"])
    }

    def wrap(alpha: Array) -> Array:
        found = {(i, word): np.interp(alpha[:, i], grid, table) for (i, word), table in tables.items()}
        return np.stack([sum(found[key] for key in enumerate(c["route"])) for c in neck["cables"]], axis=-1)

    return wrap


def cable_outlines(neck: dict[str, Any], alpha: Array) -> list[Complex]:
    """Points along every cable at one pose, alpha of shape (N,), rad: M arrays of shape (P,), m, in the base frame."""
    m = neck["mechanisms"]
    sizes = (np.array([x["L"] for x in m]), np.array([x["b"] for x in m]))
    bars = solve(np.asarray(alpha, dtype=float), *sizes)
    return [
        np.concatenate(
            [
                bars.middle[i]
                + np.exp(1j * bars.orientation[i]) * piece(w, alpha[i], m[i]["L"], m[i]["b"], m[i]["r"]).outline()
                for i, w in enumerate(cable["route"])
            ]
        )
        for cable in neck["cables"]
    ]


@dataclass(frozen=True)
class CableTable:
    """l(alpha) and dl/dalpha of all cables for one pose at a time, fast: cubic Hermite pieces between exact nodes.

    At a node distance of 2 mrad the interpolation is exact to rounding in l and to 1e-12 m in dl/dalpha.
    """

    coefficients: NDArray[np.float64]
    """powers 3..0 of (alpha - node) by mechanism and interval, shape (N, I, 4, M)"""
    first: float
    """rad"""
    step: float
    """rad"""

    def __call__(self, alpha: Array) -> tuple[Array, Array]:
        """Lengths, shape (M,), m, and dl_j/dalpha_i, shape (N, M), m, at alpha of shape (N,), rad."""
        place = (alpha - self.first) / self.step
        index = place.astype(np.intp)
        if place.min() < 0 or index.max() >= self.coefficients.shape[1]:
            raise ValueError(f"the arm left the table's range: alpha = {np.degrees(alpha)} deg")
        u = ((place - index) * self.step)[:, None]
        c3, c2, c1, c0 = self.coefficients[np.arange(len(alpha)), index].swapaxes(0, 1)
        length = ((c3 * u + c2) * u + c1) * u + c0
        return length.sum(axis=0), (3 * c3 * u + 2 * c2) * u + c1


def cable_table(neck: dict[str, Any], reach: float = 1.6, nodes: int = 1601) -> CableTable:
    """The table for a neck (the parsed neck.yaml) and |alpha| < reach, rad."""
    grid = np.linspace(-reach, reach, nodes)
    m, cables = neck["mechanisms"], neck["cables"]
    out = np.zeros((len(m), nodes - 1, 4, len(cables)))
    for j, cable in enumerate(cables):
        for i, word in enumerate(cable["route"]):
            p = piece(word, grid, m[i]["L"], m[i]["b"], m[i]["r"])
            out[i, :, :, j] = CubicHermiteSpline(grid, p.length, p.slope).c.T
    return CableTable(out, float(grid[0]), float(grid[1] - grid[0]))
