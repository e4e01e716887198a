"""A log without the rows in which a controller repeated one sample while the motors moved on."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from xneck_foundation.one_line import counted
from xneck_foundation.recovery import warn_recovered

MIN_REPEATED_ROWS = 3
"""equal rows in turn that may be one sample repeated, though motors did not jump before them (docs/thresholds.md)"""
MIN_JUMP_COUNTS = 2.5
"""encoder counts that some motor must jump after equal rows; an arm at rest repeats its rows truly (docs/thresholds.md)"""
MAX_ROWS_OF_SAMPLE = 12
"""rows of a logger that asks so many times as often as the drive has something new"""
MIN_NEW_SAMPLES, MAX_OUT_OF_STEP = 50, 0.01
"""rows that differ from the one before, of which at most a share is not on every so many (docs/thresholds.md)"""


def rows_of_sample(equal: NDArray[np.bool_]) -> tuple[int, int]:
    """How many rows in turn hold each sample, one of them for most logs, and the first row that holds a new one.

    equal: whether each row but the first (T - 1,) is the one before."""
    new = np.flatnonzero(~equal) + 1
    if len(new) >= MIN_NEW_SAMPLES:
        for rows in range(MAX_ROWS_OF_SAMPLE, 1, -1):
            phases = np.bincount(new % rows, minlength=rows)
            first = int(np.argmax(phases))
            if len(new) - phases[first] <= MAX_OUT_OF_STEP * len(new):
                return rows, first
    return 1, 0


def sampled_rows(log: Series) -> NDArray[np.bool_]:
    """Which rows of a log were sampled, (T,): of rows that repeat one sample the first.

    A logger that asks twice as often as the drive has something new writes pairs of rows; where motors are slow two equal rows are
    usual."""
    equal = np.ones(len(log) - 1, dtype=bool)
    for column in log.columns.values():
        equal &= np.diff(column) == 0
    rows, first = rows_of_sample(equal)
    if rows > 1:
        return (np.arange(len(log)) % rows == first) | np.r_[True, ~equal]
    sampled = np.ones(len(log), dtype=bool)
    theta = log.matrix("theta").T
    moves = (np.abs(np.diff(column)) for column in theta)
    count = np.array([np.min(moved, where=moved > 0, initial=np.inf) for moved in moves])
    edges = np.flatnonzero(np.diff(np.r_[False, equal, False].astype(int)))
    begin, end = edges[::2], edges[1::2]  # rows begin..end are equal, each pair of them
    after = (theta[:, np.minimum(end + 1, len(log) - 1)] - theta[:, end]) / count[:, None]
    before = (theta[:, begin] - theta[:, np.maximum(begin - 1, 0)]) / count[:, None]
    leaps = np.abs(after) > MIN_JUMP_COUNTS
    # what went fast before and after one row did not rest for it
    long = (end - begin + 1 >= MIN_REPEATED_ROWS) | np.any(leaps & (after * before > MIN_JUMP_COUNTS**2), axis=0)
    for k in np.flatnonzero(long & leaps.any(axis=0)):
        sampled[begin[k] + 1 : end[k] + 1] = False
    return sampled


def true_rows(log: Series, path: str | Path) -> Series:
    """The log's rows that were sampled, with a warning where others are left out; `path` says where they come from."""
    sampled = sampled_rows(log)
    if sampled.all():
        return log
    warn_recovered(
        path,
        f"{counted(int(np.sum(~sampled)), 'row')} repeat the one before, all columns, while motors moved on (the first at "
        f"{float(log.time[np.argmin(sampled)]):.6g} s): they were left out, as if the log had a gap there",
    )
    return log.part(sampled)
