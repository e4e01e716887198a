"""A recording cut into windows of equal length, each simulated from the state that was measured at its beginning."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset import DataSet
from xneck.errors import Refused

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

    @property
    def kept(self) -> int:
        """Rows in windows."""
        return self.count * self.samples

    @property
    def seconds(self) -> float:
        """Of a window."""
        return self.samples * self.step

    @property
    def time(self) -> Array:
        """Of a window's rows, (samples,), s from its beginning."""
        return self.step * np.arange(self.samples, dtype=float)

    def cut(self, values: Array) -> Array:
        """(T, columns) -> (windows, samples, columns)."""
        return values[: self.kept].reshape(self.count, self.samples, -1)

    def state(self, stem: str, suffix: str = "") -> Array:
        """Columns of the state, (windows, samples, columns)."""
        return self.cut(self.data.state.matrix(stem, suffix))

    def whole(self) -> NDArray[np.bool_]:
        """Windows in which the log has no gap and vision missed no joint for long, (windows,)."""
        time = self.data.state.time
        missed = np.asarray(np.any(self.data.state.matrix("bridged") > 0, axis=1))
        for begin, end in self.data.clock.get("log_gaps", ()):
            missed |= (time > begin - self.step) & (time < end + self.step)
        return ~np.any(self.cut(missed[:, None]), axis=(1, 2))

    def covariance(self) -> Array:
        """Of alpha and alpha' of all joints at the windows' beginnings, (windows, 2 N, 2 N); zero where nothing is said."""
        data, n = self.data, self.data.arm.N
        at = data.state.time[: self.kept : self.samples]
        names = [f"alpha{i + 1}{suffix}" for suffix in ("", "_d") for i in range(n)]
        out = np.zeros((self.count, 2 * n, 2 * n))
        known = data.covariance
        if known is None:
            for i, name in enumerate(names):
                sigma = data.state.columns.get(f"sigma_{name}")
                out[:, i, i] = 0.0 if sigma is None else sigma[: self.kept : self.samples] ** 2
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
