"""Consecutive parts of a long recording: spans of its camera's time, and the rows of its log at even steps."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from synchronisation.angles import Angles
from synchronisation.time_stamps import sampling_step

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EvenRows:
    """The log at equal steps, row by row where it is asked for: what `uniformly_sampled` gives, of some rows alone."""

    log: Series
    time: Array
    """(T,), s, of all rows"""

    def part(self, begin: int, end: int) -> Series:
        """Rows begin to end, by linear interpolation where rows of the log are missing or late."""
        time = self.time[begin:end]
        first, last = np.searchsorted(self.log.time, time[[0, -1]])
        near = self.log.part(slice(max(int(first) - 1, 0), int(last) + 1))
        return Series(time, {name: np.interp(time, near.time, values) for name, values in near.columns.items()})


def even_rows(log: Series) -> EvenRows:
    """Rows at the steps of `uniformly_sampled`."""
    span = log.time[-1] - log.time[0]
    count = round(span / sampling_step(log.time, "log")) + 1
    return EvenRows(log, log.time[0] + np.arange(count) * span / (count - 1))


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
