"""Stamps that tell less well when rows were sampled than the rows' numbers do: of whole milliseconds, or unsteady by some.

A control loop samples at even steps, and its stamps may be those of a counter. The motors' angles tell which of the two is true: at
the times of sampling each is where those beside it let expect it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synchronisation.time_stamps import row_numbers

Array = NDArray[np.float64]

MAX_EVEN_SHARE = 0.7
"""at even times motors' angles may be beside what their neighbours let expect by at most this share of what they are at the
stamps (docs/thresholds.md)"""
_NOTICED = 0.01
"""of a step: steps that differ by less are even"""
_FEWEST_ROWS = 100
_STEPS = 10
"""of which the usual length is told: that of single ones may be of two kinds"""


@dataclass(frozen=True)
class EvenTimes:
    """Times that rows most likely have in place of their stamps."""

    time: Array
    """(T,), s"""
    step: float
    """s"""
    spread: float
    """s: standard deviation of the stamps about them"""


def even_times_of(time: Array, theta: Array) -> EvenTimes | None:
    """Even times for rows stamped at `time` (T,), s, with motor angles theta (T, M); None where the stamps are as good.

    Rows that are missing leave holes in the even times, too. A loop that does not keep its pace, so that some row is more than a
    step beside its time, has none."""
    steps = np.diff(time)
    if len(time) < _FEWEST_ROWS:
        return None
    step = float(np.median(time[_STEPS:] - time[:-_STEPS])) / _STEPS
    if np.std(steps[steps < 2 * step]) < _NOTICED * step:
        return None
    even = _even(time, step)
    if np.max(np.abs(time - even)) > step:
        return None
    at_stamps, at_even = (np.array([_surprise(at, column) for column in theta.T]) for at in (time, even))
    turning = at_stamps > 0
    if not turning.any() or np.median(at_even[turning] / at_stamps[turning]) > MAX_EVEN_SHARE:
        return None
    return EvenTimes(even, float(np.median(np.diff(even))), float(np.std(time - even)))


def _even(time: Array, step: float) -> Array:
    """Times on a line along the rows' numbers; rows that are missing are counted."""
    number = row_numbers(time, step)
    return np.polynomial.Polynomial.fit(number, time, 1)(number)


def _surprise(time: Array, theta: Array) -> float:
    """Mean distance of a motor's angles (T,) from cubics through two rows before each and two behind it."""
    middle = time[2:-2]
    others = [time[:-4], time[1:-3], time[3:-1], time[4:]]
    values = [theta[:-4], theta[1:-3], theta[3:-1], theta[4:]]
    beside = np.zeros(len(middle))
    for i, at in enumerate(others):
        weight = np.prod([(middle - o) / (at - o) for k, o in enumerate(others) if k != i], axis=0)
        beside += weight * (values[i] - theta[2:-2])  # what rests does so to the last bit
    return float(np.mean(np.abs(beside)))
