"""Rows of the log that are missing, or repeat one sample while the motors moved on."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series

Array = NDArray[np.float64]

HELD_ROWS = 3
"""equal rows in turn that may be a burst of repeats"""
JUMP = 2.5
"""counts that some motor must leap after a burst: at rest rows repeat truly"""
WIDE = 0.01
"""s without a true row that are reported as a gap; shorter ones are bridged"""


@dataclass(frozen=True)
class Mended:
    """The log without its repeats, and the stretches in which nothing true is known."""

    log: Series
    held: int
    """rows that repeated a sample"""
    missing: int
    """rows that are missing between two stamps"""
    gaps: tuple[tuple[float, float], ...]
    """from, to of stretches wider than WIDE, s"""

    def outside(self, time: Array, margin: float) -> NDArray[np.bool_]:
        """Which log times stay `margin` s clear of every gap, (T,)."""
        clear = np.ones(len(time), dtype=bool)
        for begin, end in self.gaps:
            clear &= (time < begin - margin) | (time > end + margin)
        return clear


def mend(log: Series) -> Mended:
    """Drops repeats (the first of each burst is true) and finds the gaps."""
    values = np.stack(list(log.columns.values()), axis=1)
    theta = log.matrix("theta")
    same = np.all(np.diff(values, axis=0) == 0, axis=1)
    keep = np.ones(len(log), dtype=bool)
    moved = np.abs(np.diff(theta, axis=0))
    count = np.min(moved, axis=0, where=moved > 0, initial=np.inf)
    edges = np.flatnonzero(np.diff(np.r_[False, same, False].astype(int)))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):  # rows begin..end are equal
        if end - begin + 1 >= HELD_ROWS and end < len(moved) and np.any(moved[end] > JUMP * count):
            keep[begin + 1 : end + 1] = False
    true = log.part(keep)
    steps = np.diff(log.time)
    missing = int(np.maximum(np.rint(steps / np.median(steps)) - 1, 0).sum())
    wide = np.flatnonzero(np.diff(true.time) > WIDE)
    gaps = tuple((float(true.time[k]), float(true.time[k + 1])) for k in wide)
    return Mended(true, int(np.sum(~keep)), missing, gaps)
