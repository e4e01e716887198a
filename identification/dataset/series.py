"""Series of named columns over time, which every exchange file holds, whichever its format."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_jumps import refuse_set_clock, stamp
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import counted

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Series:
    """Columns of equal length over `time`, shape (T,), s; an unknown value is NaN."""

    time: Array
    columns: Mapping[str, Array]

    def __post_init__(self) -> None:
        if any(len(c) != len(self.time) for c in self.columns.values()):
            raise ValueError("columns and time differ in length")

    def __len__(self) -> int:
        return len(self.time)

    def part(self, rows: slice | NDArray[np.bool_] | NDArray[np.intp]) -> "Series":
        """Some of the rows, in the order in which they are named."""
        return Series(self.time[rows], {name: values[rows] for name, values in self.columns.items()})

    def matrix(self, stem: str, suffix: str = "") -> Array:
        """Columns `stem1suffix`, `stem2suffix`, ... side by side, shape (T, count)."""
        columns = []
        while (name := f"{stem}{len(columns) + 1}{suffix}") in self.columns:
            columns.append(self.columns[name])
        # each column in one piece: numbers of every column then multiply whole pieces
        return np.stack(columns).T if columns else np.empty((len(self.time), 0))


def concatenated(parts: Sequence[Series]) -> Series:
    """Series with the same columns, one after another."""
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns}
    return Series(np.concatenate([part.time for part in parts]), columns)


def interpolated(time: Array, series_time: Array, columns: Array) -> Array:
    """Columns (S, K), known at series_time (S,), s, at times (T,), s: linear, held before and after; (T, K)."""
    return np.stack([np.interp(time, series_time, column) for column in columns.T]).T


def clear_of_gaps(time: Array, gaps: Iterable[Sequence[float]], margin: float) -> NDArray[np.bool_]:
    """Which times (T,) are at least `margin` before the begin or after the end of every gap, all in s."""
    clear = np.ones(len(time), dtype=bool)
    for begin, end in gaps:
        clear &= (time < begin - margin) | (time > end + margin)
    return clear


def numbered_columns(stem: str, values: Array, suffix: str = "") -> dict[str, Array]:
    """Columns of a matrix (T, count) by the names that `Series.matrix` reads."""
    return {f"{stem}{i + 1}{suffix}": values[:, i] for i in range(values.shape[1])}


MAX_TIME_S = 2.0**31
"""s: largest time of a ROS stamp, in the year 2038; nanoseconds taken for seconds exceed it (docs/thresholds.md)"""
PAUSE_S, MAX_PAUSE_RATIO = 10.0, 9.0
"""s without a row that count as a pause, and largest ratio of all pauses to the rest of the time: beyond it a clock jumped
(docs/thresholds.md)"""
_NEAR_BEGIN = 0.1
"""share of the time before a jump back that may lie between the begin and where it goes to, if it is called a new beginning"""


def from_one(row: int) -> int:
    """What a person calls a row, which is counted from 0, where it stands in no file that has lines."""
    return row + 1


def check_time(time: Array, where: str, number: Callable[[int], int] = from_one) -> None:
    """Raises Refused where times of a record are fewer than two, in no order, or of two records; number: as people count rows."""
    if len(time) < 2:
        raise Refused(where, f"has {counted(len(time), 'row')}", "record longer")
    check_order(time, where, number)
    steps = np.diff(time)
    pausing = steps > PAUSE_S
    for row in np.flatnonzero(pausing) + 1:
        refuse_set_clock(time, int(row), where, number)
    pauses = steps[pausing]
    if np.sum(pauses) > MAX_PAUSE_RATIO * (time[-1] - time[0] - np.sum(pauses)):
        row = int(np.argmax(steps))
        raise Refused(
            where,
            f"time jumps by {steps[row]:.6g} s in row {number(row + 1)}, from {stamp(time[row])} to {stamp(time[row + 1])}",
            "cut it in two there",
        )


def check_order(time: Array, where: str, number: Callable[[int], int] = from_one) -> None:
    """Raises Refused where times are not finite, do not increase, or are none; number: what a person calls a row."""
    if not np.all(np.isfinite(time)):
        row = int(np.argmin(np.isfinite(time)))
        raise Refused(where, f"time is not finite in row {number(row)}", "leave such rows out")
    steps = np.diff(time)
    if np.any(steps <= 0):
        row = int(np.argmax(steps <= 0)) + 1
        refuse_backwards(time, where)
        refuse_set_clock(time, row, where, number)
        if begins_again(time, row):
            what = f"time begins again in row {number(row)}, with {stamp(time[row])} after {stamp(time[row - 1])}"
            raise Refused(where, f"{what}, as where two recordings are joined", "cut them apart there")
        word = "stands still" if steps[row - 1] == 0 else "jumps back"
        raise Refused(where, f"time {word} in row {number(row)}", "give each row a later time than the one before")
    if np.max(np.abs(time), initial=0.0) > MAX_TIME_S:
        do = f"times are seconds, up to {MAX_TIME_S:.0f}: subtract the first time from all"
        raise Refused(where, f"has a time of {np.max(np.abs(time)):.3g}", do)


def refuse_backwards(time: Array, where: str, name: str = "time") -> None:
    """Refused where times (T,) of three rows or more fall from each to the next, as in a table with the latest row on top."""
    if len(time) > 2 and np.all(np.diff(time) <= 0) and time[-1] < time[0]:
        raise Refused(where, f"{name} runs backwards, from the first row to the last", "sort the rows by their time")


def begins_again(time: Array, row: int) -> bool:
    """Whether times (T,) that jump back at a row go back to where they began, or before, and grow from there on."""
    first, last = time[0], time[row - 1]
    goes_back = last > first and time[row] < first + _NEAR_BEGIN * (last - first)
    return bool(goes_back and row + 1 < len(time) and np.all(np.diff(time[row : row + 3]) > 0))


def check_size(columns: Mapping[str, Array], limit: float, where: str) -> None:
    """Raises Refused where a magnitude exceeds `limit`; NaN, for unknown, does not."""
    for name, values in columns.items():
        largest = np.nanmax(np.abs(values), initial=0.0)
        if largest > limit:
            raise Refused(where, f"{name} has a value of {largest:.3g}", f"expected within +-{limit:g}")
