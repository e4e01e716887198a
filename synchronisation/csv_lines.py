"""Rows of a CSV with the lines of the file that they stand in, so that a refusal names what an editor shows."""

import csv
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TextIO

from synchronisation.csv_cell import is_number
from synchronisation.csv_layout import COMMENT
from synchronisation.text_encoding import open_text
from xneck_foundation.recovery import warn_recovered


def numbered_rows(stream: TextIO, path: Path, separator: str) -> Iterator[tuple[int, list[str]]]:
    """The header and all rows, each with its line, from 1; blank lines, and lines that begin with # or %, are left out.

    Such a line is the header where it is as wide as the row below it, which holds numbers alone. A last line without a line end may
    be cut in a number: it is left out with a warning.
    """
    rows = csv.reader(_ended_lines(stream, path), delimiter=separator)
    comment: tuple[int, list[str]] | None = None
    line, is_header = 1, True
    for row in rows:
        begin, line = line, rows.line_num + 1
        if not row or not (row[0].strip() or any(cell.strip() for cell in row)):
            continue
        if row[0].startswith(COMMENT) and (row[0] not in COMMENT or len(row) == 1):
            comment = (begin, row)
            continue
        if is_header and comment is not None and len(comment[1]) == len(row) and all(map(is_number, row)):
            yield comment
        is_header = False
        yield begin, row


def _ended_lines(stream: TextIO, path: Path) -> Iterator[str]:
    """Lines of a file but for a last one, below others, that has no line end."""
    for number, line in enumerate(stream, start=1):
        if number > 1 and not line.endswith(("\n", "\r")):
            warn_recovered(
                path, f"row {number}, the last, has no line end: it may be cut in a number, and was left out"
            )
            return
        yield line


def file_line(path: Path, separator: str, rows_between: int = 0) -> Callable[[int], int]:
    """What gives the line of a row of numbers, counted from 0; rows_between: rows between the header and the first of them."""

    def of_row(row: int) -> int:
        with open_text(path) as stream:
            lines = (line for line, _ in numbered_rows(stream, path, separator))
            return next(line for number, line in enumerate(lines, start=-1 - rows_between) if number == row)

    return of_row
