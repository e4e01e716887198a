"""Consecutive parts of a long recording: spans of its camera's time, and the rows of its log at even steps."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from synchronisation.angles import Angles
from synchronisation.encoder_log import at_even_times, even_times

Array = NDArray[np.float64]
_BESIDE = 8
"""rows of the log beside a part that its rows follow from"""


@dataclass(frozen=True)
class EvenRows:
    """The log at equal steps, row by row where it is asked for: what `uniformly_sampled` gives, of some rows alone."""

    log: Series
    time: Array
    """(T,), s, of all rows"""

    step: float
    """s, between rows of the log as most are"""

    def part(self, begin: int, end: int) -> Series:
        """Rows begin to end."""
        time = self.time[begin:end]
        first, last = np.searchsorted(self.log.time, time[[0, -1]])
        near = self.log.part(slice(max(int(first) - _BESIDE, 0), int(last) + _BESIDE))
        return at_even_times(near, time, self.step)


def even_rows(log: Series) -> EvenRows:
    """Rows at the steps of `uniformly_sampled`."""
    return EvenRows(log, *even_times(log))


def angles_within(angles: Angles, first: float, last: float) -> Angles:
    """The frames of camera times first to last, s."""
    rows = (angles.time >= first) & (angles.time <= last)
    return replace(
        angles,
        time=angles.time[rows],
        alpha=angles.alpha[rows],
        sigma=angles.sigma[rows],
        light=None if angles.light is None else angles.light[rows],
        common=None if angles.common is None else angles.common[rows],
    )


def log_within(log: Series, first: float, last: float) -> Series:
    """The rows of log times first to last, s."""
    begin, end = np.searchsorted(log.time, [first, last])
    return log.part(slice(int(begin), int(end)))
