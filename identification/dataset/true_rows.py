"""A log without the rows in which a controller repeated one sample while the motors moved on."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from xneck_foundation.one_line import counted
from xneck_foundation.recovery import warn_recovered

MIN_REPEATED_ROWS = 3
"""equal rows in turn that may be one sample repeated (docs/thresholds.md)"""
MIN_JUMP_COUNTS = 2.5
"""encoder counts that some motor must jump after equal rows; an arm at rest repeats its rows truly (docs/thresholds.md)"""


def sampled_rows(log: Series) -> NDArray[np.bool_]:
    """Which rows of a log were sampled, (T,): of rows that repeat one sample the first."""
    equal = np.ones(len(log) - 1, dtype=bool)
    for column in log.columns.values():
        equal &= np.diff(column) == 0
    sampled = np.ones(len(log), dtype=bool)
    theta = log.matrix("theta").T
    moves = (np.abs(np.diff(column)) for column in theta)
    count = np.array([np.min(moved, where=moved > 0, initial=np.inf) for moved in moves])
    edges = np.flatnonzero(np.diff(np.r_[False, equal, False].astype(int)))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):  # rows begin..end are equal
        long = end - begin + 1 >= MIN_REPEATED_ROWS
        if long and end < len(equal) and np.any(np.abs(theta[:, end + 1] - theta[:, end]) > MIN_JUMP_COUNTS * count):
            sampled[begin + 1 : end + 1] = False
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
