"""Which column of an unknown table is the time of its rows."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from identification.dataset.clock_jumps import refuse_set_clock
from identification.dataset.series import Array, begins_again, refuse_backwards
from synchronisation.column_meaning import Column, column_meaning
from synchronisation.column_units import TIME_SCALES
from synchronisation.csv_cell import MOMENTS, not_a_number
from synchronisation.log_contents import LogContents
from synchronisation.row_order import rows_by_time
from synchronisation.time_stamps import MAX_BURST_SHARE, burst_share
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed
from xneck_foundation.spelling import quoted

_COUNTER_BITS = (16, 24, 32)
"""of counters that times are taken from"""
_MAX_ROWS_LOST = 20.0
"""that may be missing where such a counter runs over"""


def time_column(path: Path, columns: Sequence[Column], contents: LogContents) -> Column:
    """The column of the time: of those that are called so and grow, one that is another in every row; else any that grows evenly.

    Raises Refused where there is none."""
    named = _times(columns, contents)
    even = [c for c in columns if _grows(contents.columns[c.name]) and _even(contents.columns[c.name])]
    if not named:
        _refuse_time_in_words(path, contents, other_time=bool(even))
    if not (named or even):
        _refuse_no_time(path, columns, contents)
    if named:
        return max(named, key=lambda c: _fitness(c, contents.columns[c.name]))
    return column_meaning(even[0].name, contents.columns[even[0].name], "time", contents.units.get(even[0].name, ""))


def doubts_of_times(columns: Sequence[Column], contents: LogContents, chosen: Column) -> list[str]:
    """That other columns are called a time too."""
    others = [c.name for c in _times(columns, contents) if c.name != chosen.name]
    if not others:
        return []
    return [f"which of several times is that of the samples: {chosen.name} is taken, and not {listed(others)}"]


def nanoseconds_column(columns: Sequence[Column], contents: LogContents, time: Column) -> Column | None:
    """What is added to whole seconds, where stamps are parted in two: one in ns that begins again every second."""
    seconds, ns = contents.columns[time.name], TIME_SCALES["ns"]
    if time.unit != "s" or np.any(seconds % 1):
        return None
    for column in columns:
        values = contents.columns[column.name]
        is_part = column.unit == "ns" and column.low >= 0 and column.high * ns < 1 and not column.missing
        if is_part and np.all(np.diff(seconds + values * ns) >= 0):
            return column
    return None


def _times(columns: Sequence[Column], contents: LogContents) -> list[Column]:
    """Columns that are called a time, and grow."""
    return [c for c in columns if c.kind == "time" and _grows(contents.columns[c.name])]


def _fitness(column: Column, values: Array) -> tuple[bool, bool]:
    """Whether a time (T,) tells all rows apart, and is that of samples: what counts rows, or came in bursts, is behind it."""
    steps = np.diff(values)
    counts_rows = column.unit_by != "name" and bool(np.all(steps == 1))
    in_bursts = burst_share(steps, float(np.mean(steps))) > MAX_BURST_SHARE
    return bool(np.all(steps > 0)) and not counts_rows, not in_bursts


def _refuse_no_time(path: Path, columns: Sequence[Column], contents: LogContents) -> None:
    """Raises Refused with what keeps a column that is called a time from being one, or that none is."""
    for column in columns:
        if column.kind != "time":
            continue
        values = contents.columns[column.name]
        at = int(np.argmin(np.diff(values, prepend=-np.inf) > 0))
        row = contents.number(at)
        if at and (bits := _overflow(values, at)):
            what = f"{column.name} runs over in row {row}, as a counter of {bits} bits does"
            raise Refused(path, what, f"add {2**bits} to it from that row on")
        refuse_backwards(values, str(path), column.name)
        if at:
            second = 1 / TIME_SCALES.get(column.unit or "s", 1.0)
            refuse_set_clock(values, at, str(path), contents.number, column.name, second)
        if begins_again(values, at):
            what = f"{column.name} begins again in row {row}, as where two recordings are joined"
            raise Refused(path, what, "cut them apart there")
        if at and len(values) - at > _MAX_ROWS_LOST and np.all(np.diff(values[at:]) > 0):
            back = f"{column.name} goes back by {values[at - 1] - values[at]:.6g} in row {row}, and grows on from there"
            raise Refused(
                path, back, "are rows written twice, or was the clock set back? leave out the rows on one side"
            )
        what = f"{column.name} does not grow in row {row} as a time does"
        raise Refused(path, what, "is a row damaged? leave it out")
    growing = [c for c in columns if _grows(contents.columns[c.name])]
    rows = [c.name for c in growing if np.all(np.diff(contents.columns[c.name]) == 1)]
    if rows:
        raise Refused(path, f"no column is a time: {listed(rows)} counts rows", "log the time of each row")
    held = f" ({listed(c.name for c in columns)})" if columns else ": none holds numbers"
    raise Refused(path, f"no column grows from row to row as a time does{held}", "log the time of each row")


def _overflow(values: Array, at: int) -> int:
    """Bits of a counter (T,) that has run over its last number before row `at`; 0 where it has not."""
    step = float(np.median(np.diff(values)))
    for bits in _COUNTER_BITS:
        forward = values[at] + 2.0**bits - values[at - 1]
        if 0 < forward < _MAX_ROWS_LOST * step:
            return bits
    return 0


def _refuse_time_in_words(path: Path, contents: LogContents, *, other_time: bool) -> None:
    """Raises Refused where a column that is called a time, or all columns, hold dates or numbers in a way that is not read.

    So does any column of dates where no other may be the time."""
    for name, cell in contents.texts.items():
        what, do = not_a_number(cell)
        is_time = column_meaning(name, np.empty(0)).kind == "time" or (what in MOMENTS and not other_time)
        if do and (not contents.columns or is_time):
            raise Refused(path, f"row {contents.number(0)}, column {name}: {quoted(cell)} {what}", do)


def _grows(values: Array) -> bool:
    ordered = values[rows_by_time(values)]
    return bool(np.all(np.isfinite(values)) and np.all(np.diff(ordered) >= 0) and ordered[-1] > ordered[0])


def _even(values: Array) -> bool:
    """Whether a column (T,) grows as a time does, and not by one from row to row, as a number of each row does."""
    steps = np.diff(values)
    return bool(np.all(steps > 0) and np.quantile(steps, 0.9) < 2 * np.median(steps) and not np.all(steps == 1))
