"""CSV files with a header, read by column name."""

import csv
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from synchronisation.csv_cell import is_number, not_a_number, number_in, unit_in, with_point
from synchronisation.csv_header import (
    WrittenOtherwise,
    missing_columns,
    other_kind,
    parted_by_spaces,
    refuse_header_again,
    spelled_otherwise,
)
from synchronisation.csv_layout import layout_of, refuse_lines_above_header
from synchronisation.csv_lines import numbered_rows
from synchronisation.text_encoding import open_text
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input
from xneck_foundation.spelling import quoted

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CsvFormat:
    """How a CSV is written."""

    time_column: str = "time"
    separator: str = ","
    decimal: str = "."
    units_row: bool = False
    """whether the row below the header holds units"""


PLAIN = CsvFormat()


_MANY_CELLS = 1.5
"""times as many cells as the header has, from which on decimals are parted too"""
_ROWS_AT_ONCE = 50_000
"""rows that are held as Python's numbers, which take ten times as much memory"""


def read_table(
    path: str | Path,
    required: Sequence[str],
    optional: Sequence[str] = (),
    written: CsvFormat = PLAIN,
    max_rows: int | None = None,
    check_units: Callable[[Mapping[str, str]], object] = lambda units: None,
) -> Series:
    """The time's column, all of `required`, and those of `optional` that the file has; empty cells are NaN.

    max_rows: more are refused, before they are all in memory. check_units: is given what the row of units holds, by column.

    Raises Refused for missing or doubled columns and for cells that are not numbers, naming row and column.
    """
    path = Path(path)
    check_input(path)
    try:
        with open_text(path) as stream:
            rows = numbered_rows(stream, path, written.separator)
            header = [cell.strip() for cell in next(rows, (1, []))[1]]
            if not header:
                raise Refused(path, "is empty", "expected a header and rows of numbers")
            if written.decimal != ".":
                rows = ((line, [with_point(cell, written.decimal) for cell in row]) for line, row in rows)
            if written.units_row:
                check_units(dict(zip(header, _row_of_units(path, rows), strict=False)))
            below = (row for _, row in rows)
            try:
                at = table_columns(path, header, below, (written.time_column, *required), optional)
            except WrittenOtherwise:
                refuse_lines_above_header(path, layout_of(path))
                raise
            columns = _columns(path, header, rows, at, max_rows)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise unreadable(path, error) from error
    if not columns[written.time_column]:
        raise Refused(path, "has a header but no rows", "record longer")
    # column by column, each given up in its pieces as it is joined: not all is there twice
    joined = {name: np.concatenate(columns.pop(name)) for name in at}
    return Series(joined.pop(written.time_column), joined)


def other_width(line: int, row: Sequence[str], header: Sequence[str]) -> tuple[str, str]:
    """What is wrong with a row that has not as many cells as the header, and what to do."""
    what = f"row {line} has {len(row)} cells, the header {len(header)}"
    if len(row) > _MANY_CELLS * len(header):
        return (
            what,
            "are its decimals written with commas, which part cells too? write points, or part cells by semicolons",
        )
    return what, "is it half-written?"


def _columns(
    path: Path,
    header: Sequence[str],
    rows: Iterator[tuple[int, list[str]]],
    at: Mapping[str, int],
    max_rows: int | None,
) -> dict[str, list[Array]]:
    """The columns that stand at the places `at`, each in pieces."""
    places, table, rows_before = list(at.values()), list[list[float]](), 0
    columns = {name: list[Array]() for name in at}
    for line, row in rows:
        if len(row) != len(header):
            raise Refused(path, *other_width(line, row, header))
        try:
            table.append(row_numbers([row[k] for k in places]))
        except ValueError:
            refuse_header_again(path, line, header, row)
            below = next(rows, (line, []))[1] if not table and not rows_before else []
            raise _no_numbers(path, line, {name: row[k] for name, k in at.items()}, row, below) from None
        if max_rows is not None and rows_before + len(table) > max_rows:
            raise Refused(path, f"has more than {max_rows} rows", "cut log and angles in parts, hours each")
        if len(table) == _ROWS_AT_ONCE:
            _add_rows(columns, table)
            rows_before += len(table)
            table.clear()
    _add_rows(columns, table)
    return columns


def _row_of_units(path: Path, rows: Iterator[tuple[int, list[str]]]) -> list[str]:
    """The row of units. Raises Refused where it holds numbers."""
    line, row = next(rows, (0, []))
    if any(cell.strip() and is_number(cell) for cell in row):
        raise Refused(path, f"row {line} holds numbers, and no units", "leave log: {units_row: true} out of neck.yaml")
    return [unit_in(cell) for cell in row]


def _no_numbers(path: Path, line: int, cells: Mapping[str, str], row: Sequence[str], below: Sequence[str]) -> Refused:
    """The refusal of a row of which not all `cells`, by column, are numbers; below: the row after the first one, else empty."""
    if any(map(is_number, below)) and not any(map(is_number, cells.values())):
        what = f"row {line} holds no numbers but {quoted(','.join(row))}, as units do"
        return WrittenOtherwise(path, what, "leave that row out")
    name, cell = next(((name, cell) for name, cell in cells.items() if not is_number(cell)), next(iter(cells.items())))
    what, do = not_a_number(cell)
    return Refused(path, f"row {line}, column {name}: {quoted(cell)} {what}", do)


def unreadable(path: Path, error: OSError | UnicodeDecodeError | csv.Error) -> Refused:
    """The refusal of a file that cannot be read as CSV."""
    if isinstance(error, UnicodeDecodeError):
        return Refused(path, "cannot be read as CSV (not UTF-8 text)", "export it as CSV, in UTF-8")
    if isinstance(error, OSError):
        return Refused(path, f"cannot be read ({error.strerror or error})")
    return Refused(path, f"cannot be read as CSV ({error})", "is it a table of numbers below a header?")


def _add_rows(columns: Mapping[str, list[Array]], table: Sequence[Sequence[float]]) -> None:
    """Rows of numbers as one more piece of each column."""
    if table:
        for pieces, values in zip(columns.values(), np.array(table).T, strict=True):
            pieces.append(values.copy())


def table_columns(
    path: Path, header: list[str], rows: Iterator[list[str]], required: Sequence[str], optional: Sequence[str]
) -> dict[str, int]:
    """Places of the columns that are read, by name. Raises Refused where one is missing, or any stands twice."""
    places = {name: k for k, name in enumerate(header)}
    if any(name not in places for name in required):
        if told := other_kind(header, angles_expected="alpha1" in required):
            raise Refused(path, *told)
        row = next(rows, [])
        if parted := parted_by_spaces(header, row):
            raise Refused(path, *parted)
        raise WrittenOtherwise(path, *missing_columns(header, row, required))
    if otherwise := spelled_otherwise(header, optional):
        raise WrittenOtherwise(path, *missing_columns(header, next(rows, []), tuple(otherwise)))
    named = [name for name in header if name]
    if len(set(named)) < len(named):
        name, count = Counter(named).most_common(1)[0]
        raise Refused(path, f"has the column {quoted(name)} {count} times", "name each column once")
    return {name: places[name] for name in (*required, *optional) if name in places}


def row_numbers(cells: list[str]) -> list[float]:
    """The numbers in cells, as `number_in` gives each. Raises ValueError."""
    if "_" not in "".join(cells):
        # nearly all rows: one pass in C
        with suppress(ValueError):
            return list(map(float, cells))
    return [number_in(cell) for cell in cells]
