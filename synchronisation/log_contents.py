"""All that is in a log of any kind, whatever its columns or joints are called: to look at it before it is mapped."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Array
from identification.files import joint_state, ros_bag
from synchronisation.csv_cell import unit_in, with_point
from synchronisation.csv_header import parted_by_spaces, refuse_header_again
from synchronisation.csv_layout import layout_of, refuse_lines_above_header
from synchronisation.csv_lines import numbered_rows
from synchronisation.csv_table import PLAIN, CsvFormat, other_width, unreadable
from synchronisation.encoder_log import LOG_SUFFIXES
from synchronisation.parquet_table import numeric_columns
from synchronisation.text_encoding import open_text
from xneck_foundation.errors import Refused
from xneck_foundation.file_kind import refuse_other_kind
from xneck_foundation.input_file import check_input
from xneck_foundation.spelling import quoted


@dataclass(frozen=True)
class LogContents:
    """Columns (T,) of a table, or joints of JointState topics with their own stamps."""

    columns: Mapping[str, Array] = field(default_factory=dict)
    """of a CSV or Parquet: all that are numbers, as they stand in the file"""
    texts: Mapping[str, str] = field(default_factory=dict)
    """columns of a CSV that are no numbers, with what stands in their first row"""
    written: CsvFormat = PLAIN
    topics: Mapping[str, joint_state.JointStateChannel] = field(default_factory=dict)
    """of an MCAP or a ROS bag"""
    faults: Mapping[str, str] = field(default_factory=dict)
    """what is wrong with each topic that cannot be read"""
    units_row: int | None = None
    """line of a CSV's row below the header, where it holds units instead of numbers"""
    units: Mapping[str, str] = field(default_factory=dict)
    """what stands in that row, by column"""
    lines: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    """(T,): of a CSV, the line of each row; empty of other files"""
    odd_rows: tuple[int, ...] = ()
    """lines of a CSV that have more or fewer cells than the header, and were left out"""

    def number(self, row: int) -> int:
        """What a person calls a row, which is counted from 0: its line in a CSV, else the number from 1."""
        return int(self.lines[row]) if len(self.lines) else row + 1


def read_contents(path: Path) -> LogContents:
    """What a log holds. Raises Refused where it is of no kind that is read, or is damaged."""
    check_input(path)
    if path.suffix.lower() == ".mcap":
        file = joint_state.read(path)
        return LogContents(topics=file.logs, faults=file.faults)
    if path.suffix.lower() in ros_bag.SUFFIXES:
        bag = ros_bag.read_bag(path)
        return LogContents(topics=bag.logs, faults=bag.faults)
    if path.suffix.lower() == ".parquet":
        return LogContents(columns=numeric_columns(path))
    refuse_other_kind(path, LOG_SUFFIXES)
    return _csv_contents(path)


def _csv_contents(path: Path) -> LogContents:
    try:
        layout = layout_of(path)
        refuse_lines_above_header(path, layout)
        separator, decimal = (layout.separator, layout.decimal) if layout else (PLAIN.separator, PLAIN.decimal)
        with open_text(path) as stream:
            rows = list(numbered_rows(stream, path, separator))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise unreadable(path, error) from error
    if not rows:
        raise Refused(path, "is empty", "expected a header and rows of numbers")
    (_, header), *rows = rows
    header = [cell.strip() for cell in header]
    if all(_number(cell, decimal) is not None for cell in header):
        raise Refused(path, "has no header: its first row holds numbers", "begin it with a row of columns' names")
    if parted := parted_by_spaces(header, rows[0][1] if rows else []):
        raise Refused(path, *parted)
    for line, row in rows:
        if row[0].strip() == header[0]:
            refuse_header_again(path, line, header, row)
    table = [(line, row) for line, row in rows if len(row) == len(header)]
    units_row = layout.units if layout and table and table[0][0] == layout.units else None
    units = [unit_in(cell) for cell in table.pop(0)[1]] if units_row else []
    if len(table) < 2 and len(rows) > 1:
        raise Refused(path, *other_width(*rows[0], header))
    if len(table) < 2:
        raise Refused(path, "has a header and no two rows of numbers", "record longer")
    columns: dict[str, Array] = {}
    texts: dict[str, str] = {}
    for name, cells in zip(header, zip(*(row for _, row in table), strict=True), strict=True):
        values = [_number(cell, decimal) for cell in cells]
        if not name and not any(cell.strip() for cell in cells):
            continue  # a separator ends each line
        if sum(value is None for value in values) > len(values) / 2:
            texts[name] = cells[0]
        elif name in columns:
            raise Refused(path, f"has the column {quoted(name)} {header.count(name)} times", "name each column once")
        else:
            columns[name] = np.array([np.nan if value is None else value for value in values])
    return LogContents(
        columns=columns,
        texts=texts,
        written=CsvFormat(separator=separator, decimal=decimal, units_row=units_row is not None),
        units_row=units_row,
        units={name: unit for name, unit in zip(header, units, strict=False) if unit},
        lines=np.array([line for line, _ in table]),
        odd_rows=tuple(line for line, row in rows if len(row) != len(header)),
    )


def _number(cell: str, decimal: str) -> float | None:
    if "_" in cell:
        return None
    text = with_point(cell.strip(), decimal)
    if not text:
        return np.nan
    try:
        return float(text)
    except ValueError:
        return None
