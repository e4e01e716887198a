"""Rows that stand a little out of the order of their times, or are written twice, as several threads or a network leave them.

The stamps say where each belongs. One that is wrong says it too, but the place that it names is not empty.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from xneck_foundation.one_line import counted
from xneck_foundation.recovery import warn_recovered

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

MAX_ROWS_BACK = 10
"""rows that one may stand from its place: further away it is of another recording, or of a clock that was set
(docs/thresholds.md)"""
MAX_LATE_SHARE = 0.1
"""share of rows that may stand behind a later one (docs/thresholds.md)"""
MIN_PLACE_STEPS = 0.5
"""of the usual step, to the rows on either side of the place where one is put: nearer to them its stamp is wrong
(docs/thresholds.md)"""


def rows_by_time(time: Array) -> Rows:
    """Rows of stamps (T,), s, in the order of their times, (T,); in that of the file where their disorder is not a small one."""
    as_written = np.arange(len(time))
    if not np.all(np.isfinite(time)) or np.all(np.diff(time) >= 0):
        return as_written
    by_time = np.argsort(time, kind="stable")
    late = time < np.maximum.accumulate(time)
    if np.max(np.abs(by_time - as_written)) > MAX_ROWS_BACK or np.mean(late) > MAX_LATE_SHARE:
        return as_written
    steps = np.diff(time[by_time])
    is_beside_moved = late[by_time][1:] | late[by_time][:-1]
    crowded = is_beside_moved & (steps > 0) & (steps < MIN_PLACE_STEPS * np.median(steps))
    return as_written if crowded.any() else by_time


def kept_rows(series: Series) -> Rows:
    """Rows in the order of `rows_by_time`, without those that repeat another in full, its time too."""
    rows = rows_by_time(series.time)
    repeats = np.diff(series.time[rows], prepend=np.nan) == 0
    for column in series.columns.values():
        values = column[rows]
        repeats[1:] &= (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    return rows[~repeats]


def in_order(series: Series, path: str | Path) -> tuple[Series, Rows]:
    """The rows that are kept, with a warning about what was changed, and which they are in the file."""
    kept = kept_rows(series)
    left_out, said = len(series) - len(kept), []
    if np.any(np.diff(kept) < 0):
        late = int(np.sum(series.time < np.maximum.accumulate(series.time)))
        said.append(f"{counted(late, 'row')} stood behind later ones: put where their times belong")
    if left_out:
        said.append(f"{counted(left_out, 'row')} repeated another, its time too: left out")
    if said:
        warn_recovered(path, "; ".join(said))
    return series.part(kept), kept
