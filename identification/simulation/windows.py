"""A recording cut into windows of equal length, each simulated from the state that was measured at its beginning."""

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
    """Rows of the state in windows that follow each other; what is left at the end belongs to none."""

    data: DataSet
    step: float
    """s between rows"""
    samples: int
    """rows of a window"""
    count: int
    first: int = 0
    """of the recording's windows, where these are some of them"""

    @property
    def rows(self) -> slice:
        """Of the state, in these windows."""
        return slice(self.first * self.samples, (self.first + self.count) * self.samples)

    def parts(self, most: int) -> Iterator["Windows"]:
        """The same, at most so many at once."""
        for first in range(0, self.count, most):
            yield replace(self, first=self.first + first, count=min(most, self.count - first))

    @property
    def seconds(self) -> float:
        """Of a window."""
        return self.samples * self.step

    @property
    def time(self) -> Array:
        """Of a window's rows, (samples,), s from its beginning."""
        return self.step * np.arange(self.samples, dtype=float)

    @cached_property
    def state(self) -> Series:
        """Rows of these windows."""
        return self.data.state.part(self.rows)

    def cut(self, values: Array) -> Array:
        """A value for each row, (rows, columns) -> (windows, samples, columns)."""
        return values.reshape(self.count, self.samples, values.shape[1])

    def matrix(self, stem: str, suffix: str = "") -> Array:
        """Columns of the state, (windows, samples, columns)."""
        return self.cut(self.state.matrix(stem, suffix))

    def whole(self) -> NDArray[np.bool_]:
        """Windows in which the log has no gap and vision missed no joint for long, (windows,)."""
        time = self.state.time
        missed = np.any(self.matrix("bridged") > 0, axis=(1, 2))
        for begin, end in self.data.clock.get("log_gaps", ()):
            within = (time > begin - self.step) & (time < end + self.step)
            missed |= np.any(within.reshape(self.count, -1), axis=1)
        return ~missed

    def of_rows(self) -> NDArray[np.intp]:
        """Of the recording's windows that of each row, -1 where it has a gap, (rows,)."""
        number = self.first + np.arange(self.count)
        return np.repeat(np.where(self.whole(), number, -1), self.samples)

    def covariance(self) -> Array:
        """Of alpha and alpha' of all joints at the windows' beginnings, (windows, 2 N, 2 N); zero where nothing is said."""
        data, n = self.data, self.data.arm.N
        at = self.state.time[:: self.samples]
        names = [f"alpha{i + 1}{suffix}" for suffix in ("", "_d") for i in range(n)]
        out = np.zeros((self.count, 2 * n, 2 * n))
        known = data.covariance
        if known is None:
            for i, name in enumerate(names):
                sigma = self.state.columns.get(f"sigma_{name}")
                out[:, i, i] = 0.0 if sigma is None else sigma[:: self.samples] ** 2
            return out
        for i, one in enumerate(names):
            for j in range(i, 2 * n):
                out[:, i, j] = out[:, j, i] = np.interp(at, known.time, known.columns[f"cov_{one}_{names[j]}"])
        return out


def windows_of(data: DataSet, window_s: float | None) -> Windows:
    """Of `window_s` seconds, or the whole recording as one. Raises Refused where it is shorter than a window."""
    rows = len(data.state)
    step = float(np.mean(np.diff(data.state.time)))
    samples = rows if window_s is None else round(window_s / step)
    if samples < 2 or samples > rows:
        raise Refused("simulate", f"a window of {window_s} s does not fit {rows * step:.1f} s of data")
    return Windows(data, step, samples, rows // samples)
