"""A recording cut into windows of equal length; each is simulated from the state that was measured at its beginning."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Windows:
    """Successive windows of the state's rows; rows at the end that do not fill a window belong to none."""

    data: DataSet
    step: float
    """time between rows, s"""
    samples: int
    """rows of a window"""
    count: int
    first: int = 0
    """number of the first window in the recording, where these are only some of its windows"""

    @property
    def rows(self) -> slice:
        """Rows of the state in these windows."""
        return slice(self.first * self.samples, (self.first + self.count) * self.samples)

    def parts(self, max_count: int, max_parts: int | None = None) -> Iterator["Windows"]:
        """These windows, at most `max_count` at once; of more than `max_parts` parts so many, evenly spread."""
        begins = np.arange(0, self.count, max_count)
        if max_parts is not None and len(begins) > max_parts:
            begins = np.linspace(0, self.count - max_count, max_parts).round().astype(int)
        for first in begins.tolist():
            yield replace(self, first=self.first + first, count=min(max_count, self.count - first))

    @property
    def seconds(self) -> float:
        """Length of a window, s."""
        return self.samples * self.step

    @property
    def time(self) -> Array:
        """Times of a window's rows from its beginning, (samples,), s."""
        return self.step * np.arange(self.samples, dtype=float)

    @property
    def began(self) -> Array:
        """When the recording began, in the time of each window, (windows,), s."""
        first = self.rows.start + self.samples * np.arange(self.count)
        return np.asarray(-self.step * first, dtype=float)

    @cached_property
    def state(self) -> Series:
        """The state in these windows."""
        return self.data.state.part(self.rows)

    def cut(self, values: Array) -> Array:
        """Values of the rows, (rows, columns) -> (windows, samples, columns)."""
        return values.reshape(self.count, self.samples, values.shape[1])

    def matrix(self, stem: str, suffix: str = "") -> Array:
        """Columns of the state, (windows, samples, columns)."""
        return self.cut(self.state.matrix(stem, suffix))

    def complete(self) -> NDArray[np.bool_]:
        """Which windows have no gap of the log and no joint that vision missed for long, (windows,)."""
        time = self.state.time
        missed = np.any(self.matrix("bridged") > 0, axis=(1, 2))
        for begin, end in self.data.clock.get("log_gaps", ()):
            within = (time > begin - self.step) & (time < end + self.step)
            missed |= np.any(within.reshape(self.count, -1), axis=1)
        return ~missed

    def number_of_rows(self) -> NDArray[np.intp]:
        """Number of each row's window in the recording, -1 where the window is not complete, (rows,)."""
        number = self.first + np.arange(self.count)
        return np.repeat(np.where(self.complete(), number, -1), self.samples)

    def covariance(self) -> Array:
        """Covariance of alpha, alpha' at the windows' beginnings, (windows, 2 N, 2 N); zero where the data set has none."""
        data, n = self.data, self.data.arm.N
        begin_time = self.state.time[:: self.samples]
        names = [f"alpha{i + 1}{suffix}" for suffix in ("", "_d") for i in range(n)]
        out = np.zeros((self.count, 2 * n, 2 * n))
        series = data.covariance
        if series is None:
            for i, name in enumerate(names):
                sigma = self.state.columns.get(f"sigma_{name}")
                out[:, i, i] = 0.0 if sigma is None else sigma[:: self.samples] ** 2
            return out
        for i, name in enumerate(names):
            for j in range(i, 2 * n):
                out[:, i, j] = out[:, j, i] = np.interp(
                    begin_time, series.time, series.columns[f"cov_{name}_{names[j]}"]
                )
        return out


def windows_of(data: DataSet, window_s: float | None) -> Windows:
    """Windows of `window_s` seconds, or with None the whole recording as one. Raises Refused where it is shorter than a window."""
    rows = len(data.state)
    step = float(np.mean(np.diff(data.state.time)))
    samples = rows if window_s is None else round(window_s / step)
    if samples < 2 or samples > rows:
        raise Refused("simulate", f"a window of {window_s} s does not fit {rows * step:.1f} s of data")
    return Windows(data, step, samples, rows // samples)
