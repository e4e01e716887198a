"""CSV files with a header, read by column name."""

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from identification.dataset.series import Series
from synchronisation.csv_header import missing_columns, spelled_otherwise
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input


def read_table(path: str | Path, required: Sequence[str], optional: Sequence[str] = ()) -> Series:
    """Columns `time`, all of `required`, and those of `optional` that the file has; empty cells are NaN.

    Raises Refused for missing or doubled columns and for cells that are not numbers, naming row and column.
    """
    path = Path(path)
    check_input(path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            rows = csv.reader(stream)
            header = [cell.strip() for cell in next(rows, [])]
            if not header:
                raise Refused(path, "is empty", "expected a header and rows of numbers")
            if any(name not in header for name in ("time", *required)):
                raise Refused(path, *missing_columns(header, next(rows, []), ("time", *required)))
            if otherwise := spelled_otherwise(header, optional):
                raise Refused(path, *missing_columns(header, next(rows, []), tuple(otherwise)))
            repeated = sorted({name for name in header if header.count(name) > 1})
            if repeated:
                raise Refused(path, f"has the column {repeated[0]} twice", "name each column once")
            names = ["time", *required, *(name for name in optional if name in header)]
            at = [header.index(name) for name in names]
            table = []
            for number, row in enumerate(rows, start=2):
                if not row:
                    continue
                if len(row) != len(header):
                    raise Refused(
                        path, f"row {number} has {len(row)} cells, the header {len(header)}", "is it half-written?"
                    )
                try:
                    table.append([_number(row[k]) for k in at])
                except ValueError:
                    if number == 2 and not any(_is_number(row[k]) for k in at):
                        raise Refused(
                            path,
                            f"row 2 holds no numbers but {','.join(row)[:60]!r}, as units do",
                            "leave that row out",
                        ) from None
                    k = next(k for k in at if not _is_number(row[k]))
                    raise Refused(path, f"row {number}, column {header[k]}: {row[k]!r} is not a number") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise Refused(path, f"cannot be read as CSV ({getattr(error, 'strerror', None) or error})") from error
    if not table:
        raise Refused(path, "has a header but no rows")
    values = np.array(table)
    return Series(values[:, 0], {name: values[:, k] for k, name in enumerate(names) if k})


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
