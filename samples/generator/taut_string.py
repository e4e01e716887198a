"""The exact length of a taut string over wheels, from tangents of circles and the angles wound between them.

Points are complex numbers (m). A string that travels in direction u (|u| = 1) around a wheel in the sense s (+1
counter-clockwise, -1 clockwise) touches it at centre - 1j s r u. A straight span between two wheels therefore obeys
centre_2 - centre_1 = (T + 1j (s_2 r_2 - s_1 r_1)) u with T its length: one rule for outer tangents, crossing tangents
and points (r = 0). No closed form of a cable length is used, so that the closed forms can be held against it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Wheel:
    """A wheel or, with radius 0, a point that the string passes or ends at."""

    centre: Complex
    """shape (...), m"""
    radius: float
    """m"""
    sense: int
    """+1 where the string goes round counter-clockwise, -1 clockwise"""
    about: float
    """rad; directions leave whole turns open: the angle wound is the one within half a turn of this"""


@dataclass(frozen=True)
class TautString:
    """A string from a mark on its first wheel to a mark on its last one (or to a point)."""

    wheels: tuple[Wheel, ...]
    spans: Array
    """lengths of the straight parts, shape (..., W - 1), m"""
    directions: Complex
    """unit directions of the straight parts, shape (..., W - 1)"""
    wound: Array
    """angle in contact with each wheel, shape (..., W), rad"""

    @property
    def length(self) -> Array:
        """Length from end to end, shape (...), m."""
        return self.spans.sum(axis=-1) + self.wound @ np.array([w.radius for w in self.wheels])


def tighten(wheels: Sequence[Wheel], start: Complex | None, end: Complex | None) -> TautString:
    """The taut string over `wheels`. `start`, `end`: its direction of travel at its first and last mark, shape (...).

    A string that starts or ends at a point has no direction there to be given: None.
    """
    centres = np.stack(np.broadcast_arrays(*[w.centre for w in wheels]), axis=-1)
    signed = np.array([w.sense * w.radius for w in wheels])
    across, lever = np.diff(centres, axis=-1), np.diff(signed)
    inside = np.abs(across) ** 2 - lever**2
    if np.any(inside <= 0):
        raise ValueError("two wheels overlap: no tangent")
    spans = np.sqrt(inside)
    directions = across / (spans + 1j * lever)
    arriving = [start, *np.moveaxis(directions, -1, 0)]
    leaving = [*np.moveaxis(directions, -1, 0), end]
    wound = [
        _angle_wound(w, come, go) if come is not None and go is not None else np.zeros(across.shape[:-1])
        for w, come, go in zip(wheels, arriving, leaving, strict=True)
    ]
    return TautString(tuple(wheels), spans, directions, np.stack(np.broadcast_arrays(*wound), axis=-1))


def _angle_wound(wheel: Wheel, arriving: Complex, leaving: Complex) -> Array:
    turned = wheel.sense * np.angle(leaving / arriving)
    return turned + 2 * np.pi * np.round((wheel.about - turned) / (2 * np.pi))


def outline(string: TautString, start: complex | None, points_per_turn: int = 60) -> Complex:
    """Points along one string (no leading shape) for drawing, shape (P,), m; `start` as for `tighten`."""
    arriving = [start, *string.directions]
    points: list[Complex] = []
    for wheel, come, angle in zip(string.wheels, arriving, string.wound, strict=True):
        if come is None:  # a string that starts at a point
            points.append(np.array([wheel.centre]))
            continue
        turn = np.linspace(0.0, angle, 2 + int(points_per_turn * abs(angle) / (2 * np.pi)))
        touching = come * np.exp(1j * wheel.sense * turn)
        points.append(wheel.centre - 1j * wheel.sense * wheel.radius * touching)
    return np.concatenate(points)
