"""CSV files with a header, read by column name."""

import csv
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from synchronisation.csv_header import ColumnsMissing, missing_columns, other_kind, spelled_otherwise
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


PLAIN = CsvFormat()


_ROWS_AT_ONCE = 50_000
"""rows that are held as Python's numbers, which take ten times as much memory"""


def read_table(
    path: str | Path,
    required: Sequence[str],
    optional: Sequence[str] = (),
    written: CsvFormat = PLAIN,
    max_rows: int | None = None,
) -> Series:
    """The time's column, all of `required`, and those of `optional` that the file has; empty cells are NaN.

    max_rows: more are refused, before they are all in memory.

    Raises Refused for missing or doubled columns and for cells that are not numbers, naming row and column.
    """
    path = Path(path)
    check_input(path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            rows = csv.reader(stream, delimiter=written.separator)
            header = [cell.strip() for cell in next(rows, [])]
            if not header:
                raise Refused(path, "is empty", "expected a header and rows of numbers")
            at = table_columns(path, header, rows, (written.time_column, *required), optional)
            places, table, rows_before = list(at.values()), list[list[float]](), 0
            columns = {name: list[Array]() for name in at}
            for number, row in enumerate(rows, start=2):
                if not row:
                    continue
                if len(row) != len(header):
                    raise Refused(
                        path, f"row {number} has {len(row)} cells, the header {len(header)}", "is it half-written?"
                    )
                if written.decimal != ".":
                    row = [cell.replace(written.decimal, ".") for cell in row]
                try:
                    table.append(row_numbers([row[k] for k in places]))
                except ValueError:
                    if number == 2 and not any(_is_number(row[k]) for k in at.values()):
                        what = f"row 2 holds no numbers but {quoted(','.join(row))}, as units do"
                        raise Refused(path, what, "leave that row out") from None
                    name = next(name for name, k in at.items() if not _is_number(row[k]))
                    what = f"row {number}, column {name}: {quoted(row[at[name]])} is not a number"
                    raise Refused(path, what) from None
                if max_rows is not None and rows_before + len(table) > max_rows:
                    raise Refused(path, f"has more than {max_rows} rows", "cut log and angles in parts, hours each")
                if len(table) == _ROWS_AT_ONCE:
                    _add_rows(columns, table)
                    rows_before += len(table)
                    table.clear()
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise unreadable(path, error) from error
    if not rows_before and not table:
        raise Refused(path, "has a header but no rows", "record longer")
    _add_rows(columns, table)
    # column by column, each given up in its pieces as it is joined: not all is there twice
    joined = {name: np.concatenate(columns.pop(name)) for name in at}
    return Series(joined.pop(written.time_column), joined)


def unreadable(path: Path, error: OSError | UnicodeDecodeError | csv.Error) -> Refused:
    """The refusal of a file that cannot be read as CSV."""
    if isinstance(error, UnicodeDecodeError):
        return Refused(path, "cannot be read as CSV (not UTF-8 text)", "save it as UTF-8")
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
        raise ColumnsMissing(path, *missing_columns(header, next(rows, []), required))
    if otherwise := spelled_otherwise(header, optional):
        raise ColumnsMissing(path, *missing_columns(header, next(rows, []), tuple(otherwise)))
    if len(places) < len(header):
        name, count = Counter(header).most_common(1)[0]
        raise Refused(path, f"has the column {quoted(name)} {count} times", "name each column once")
    return {name: places[name] for name in (*required, *optional) if name in places}


def row_numbers(cells: list[str]) -> list[float]:
    """The numbers in cells, as `_number` gives each. Raises ValueError."""
    if "_" not in "".join(cells):
        # nearly all rows: one pass in C
        with suppress(ValueError):
            return list(map(float, cells))
    return [_number(cell) for cell in cells]


def _number(cell: str) -> float:
    """The number in a cell, NaN for an empty one. Raises ValueError, also for 1_0, which Python alone takes for 10."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell) if cell.strip() else np.nan


def _is_number(cell: str) -> bool:
    try:
        _number(cell)
    except ValueError:
        return False
    return True
