"""How a CSV is written, by its first lines: what parts its columns, what stands before decimals, and where its header is."""

import csv
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from synchronisation.csv_cell import has_decimal_comma, is_number
from synchronisation.text_encoding import open_text
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import counted

SEPARATORS = ((",", "commas"), (";", "semicolons"), ("\t", "tabs"), ("|", "bars"))
COMMENT = ("#", "%")
"""what a line of a CSV begins with that is passed over"""
_LABVIEW = b"LabVIEW Measurement"
_SNIFFED_BYTES = 1 << 16
_MIN_COLUMNS = 2


@dataclass(frozen=True)
class CsvLayout:
    """What the first lines of a table tell."""

    separator: str
    decimal: str
    header: int
    """the header's line, from 1"""
    units: int | None
    """line of a row of units between the header and the numbers"""
    above: int
    """lines above the header that are neither blank nor comments"""


def layout_of(path: Path) -> CsvLayout | None:
    """The layout of a file; None where no lines of numbers stand below a header. Raises OSError, UnicodeDecodeError."""
    with open_text(path) as stream:
        text = stream.read(_SNIFFED_BYTES)
    lines = text.splitlines()
    return layout_of_lines(lines[:-1] if len(text) == _SNIFFED_BYTES else lines)


def layout_of_lines(lines: Sequence[str]) -> CsvLayout | None:
    """The layout that explains most: a header, and below it as many cells in each row, of which most are numbers."""
    written = [(number, line) for number, line in enumerate(lines, start=1) if line.strip(" ,;|\t")]
    plain = [(number, line) for number, line in written if not line.startswith(COMMENT)]
    for kept in (plain, written):
        found = [layout for separator, _ in SEPARATORS if (layout := _parted_by(separator, kept))]
        if found:
            return max(found, key=lambda one: one[0])[1]
    return None


def refuse_lines_above_header(path: Path, layout: CsvLayout | None) -> None:
    """Raises Refused where titles or the like stand above a header, also above LabVIEW's, which is wider than its rows."""
    if layout is None and _is_labview(path):
        what = "is a LabVIEW measurement file, whose settings stand above its table"
        raise Refused(path, what, "leave out all above the row of X_Value, and Comment at the end of that row")
    if layout is not None and layout.above:
        what = f"its header is in row {layout.header}, below {counted(layout.above, 'line')} of something else"
        raise Refused(path, what, "leave them out, or let them begin with #")


def _is_labview(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(len(_LABVIEW)) == _LABVIEW


def _parted_by(separator: str, lines: Sequence[tuple[int, str]]) -> tuple[float, CsvLayout] | None:
    """The layout with one separator, and how much of the rows it explains; None where rows and a header do not fit to it."""
    table = [(number, _cells(line, separator)) for number, line in lines]
    numbers = [_numbers(cells) for _, cells in table]
    widths = Counter(
        len(cells) for (_, cells), n in zip(table, numbers, strict=True) if n and len(cells) >= _MIN_COLUMNS
    )
    if not widths:
        return None
    width = widths.most_common(1)[0][0]
    of_width = [k for k, (_, cells) in enumerate(table) if len(cells) == width]
    first = next(k for k in of_width if numbers[k])
    rows = [k for k in of_width if k >= first]
    # titles have other widths, or are filled up with empty cells
    above = [k for k in of_width if k < first and 2 * _filled(table[k][1]) >= width]
    if not above:
        return None
    header = above[0]
    in_row = sum(numbers[k] for k in rows) / len(rows)
    commas = sum(any(map(has_decimal_comma, table[k][1])) for k in rows)
    points = sum(any("." in cell and is_number(cell) for cell in table[k][1]) for k in rows)
    return in_row**2 / width, CsvLayout(
        separator=separator,
        decimal="," if separator != "," and commas > points else ".",
        header=table[header][0],
        units=table[above[1]][0] if len(above) == 2 else None,
        above=header,
    )


def _cells(line: str, separator: str) -> list[str]:
    with suppress(csv.Error):
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
    return []


def _numbers(cells: Sequence[str]) -> int:
    """How many cells hold a number, whatever stands before its decimals."""
    return sum(bool(cell) and (is_number(cell) or has_decimal_comma(cell)) for cell in cells)


def _filled(cells: Sequence[str]) -> int:
    return sum(bool(cell) for cell in cells)
