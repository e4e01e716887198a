"""A function of one coordinate or speed as a sum of ramps, each of which an actuator with a limited force makes.

MuJoCo has no friction by an arc tangent and no cable that gets stiffer. A ramp is slope (v - begin), held within 0 and its rise, so
that ramps laid end to end join points of the function by straight lines, and hold it beyond the last ones.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mechanism.arm import Array

TOLERANCE = 0.001
"""largest distance between a function and its ramps, as a share of its magnitude there (docs/thresholds.md)"""
_FLOOR = 0.01
"""share of the function's largest magnitude that counts as its magnitude where it is smaller"""
_GRID = 4000
"""points in which a function is read, on each side of zero"""
_FINEST = 1e-6
"""first of them, as a share of the last"""


@dataclass(frozen=True)
class Ramp:
    """slope (v - begin), held between `low` and `high`, one of which is zero."""

    begin: float
    slope: float
    low: float
    high: float

    def at(self, v: Array) -> Array:
        """Its value, of v's shape."""
        return np.clip(self.slope * (v - self.begin), self.low, self.high)


def ramps_of(function: Callable[[Array], Array], low: float, high: float) -> tuple[float, tuple[Ramp, ...]]:
    """The function's value at zero, and ramps that add what it does between `low` <= 0 and `high` >= 0."""
    reached = np.concatenate([function(_grid(end)) for end in (low, high) if end])
    floor = _FLOOR * float(np.abs(reached).max())
    ramps = [ramp for end in (low, high) if end for ramp in _ramps_to(function, end, floor)]
    return float(function(np.zeros(1))[0]), tuple(ramps)


def _grid(end: float) -> Array:
    return np.concatenate([np.zeros(1), end * np.geomspace(_FINEST, 1.0, _GRID)])


def _ramps_to(function: Callable[[Array], Array], end: float, floor: float) -> list[Ramp]:
    """Ramps from zero to one end, each as long as the tolerance allows; floor: least magnitude that this is a share of."""
    v = _grid(end)
    y = function(v)
    ramps, first = [], 0
    while first < _GRID:
        last = _longest_chord(v, y, first, floor)
        rise = float(y[last] - y[first])
        if rise:
            slope = rise / float(v[last] - v[first])
            ramps.append(Ramp(float(v[first]), slope, min(rise, 0.0), max(rise, 0.0)))
        first = last
    return ramps


def _longest_chord(v: Array, y: Array, first: int, floor: float) -> int:
    """The furthest point that a straight line from `first` reaches without leaving the function by more."""
    inside, outside = first + 1, len(v)
    while outside - inside > 1:
        middle = (inside + outside) // 2
        part = slice(first, middle + 1)
        slope = (y[middle] - y[first]) / (v[middle] - v[first])
        error = np.abs(y[part] - y[first] - slope * (v[part] - v[first]))
        within = bool(np.all(error <= TOLERANCE * np.maximum(np.abs(y[part]), floor)))
        inside, outside = (middle, outside) if within else (inside, middle)
    return inside
