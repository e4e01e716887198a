"""All that is in a log of any kind, whatever its columns or joints are called: to look at it before it is mapped."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from identification.dataset.series import Array
from identification.files import joint_state, ros_bag
from synchronisation.csv_header import SEPARATORS
from synchronisation.csv_table import PLAIN, CsvFormat, unreadable
from synchronisation.encoder_log import LOG_SUFFIXES
from synchronisation.parquet_table import numeric_columns
from xneck_foundation.errors import Refused
from xneck_foundation.file_kind import refuse_other_kind
from xneck_foundation.input_file import check_input
from xneck_foundation.spelling import quoted

_SNIFFED_BYTES = 1 << 16


@dataclass(frozen=True)
class LogContents:
    """Columns (T,) of a table, or joints of JointState topics with their own stamps."""

    columns: Mapping[str, Array] = field(default_factory=dict)
    """of a CSV or Parquet: all that are numbers, as they stand in the file"""
    texts: tuple[str, ...] = ()
    """columns of a CSV that are no numbers"""
    written: CsvFormat = PLAIN
    topics: Mapping[str, joint_state.JointStateChannel] = field(default_factory=dict)
    """of an MCAP or a ROS bag"""
    units_row: bool = False
    """whether the row below a CSV's header holds units instead of numbers"""


def read_contents(path: Path) -> LogContents:
    """What a log holds. Raises Refused where it is of no kind that is read, or is damaged."""
    check_input(path)
    if path.suffix.lower() == ".mcap":
        return LogContents(topics=joint_state.read(path).logs)
    if path.suffix.lower() in ros_bag.SUFFIXES:
        return LogContents(topics=ros_bag.read_bag(path))
    if path.suffix.lower() == ".parquet":
        return LogContents(columns=numeric_columns(path))
    if path.suffix.lower() not in (".csv", ".txt", ".tsv", ".log"):
        what = (
            f"{quoted(path.suffix)} is no kind of log that is read"
            if path.suffix
            else "has no suffix that says its kind"
        )
        raise Refused(path, what, f"give {', '.join(LOG_SUFFIXES)}")
    refuse_other_kind(path, LOG_SUFFIXES)
    return _csv_contents(path)


def _csv_contents(path: Path) -> LogContents:
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            head = stream.read(_SNIFFED_BYTES).splitlines()
            if not head or not head[0].strip():
                raise Refused(path, "is empty", "expected a header and rows of numbers")
            separator, decimal = _written(head)
            stream.seek(0)
            rows = csv.reader(stream, delimiter=separator)
            header = [cell.strip() for cell in next(rows)]
            table = [row for row in rows if len(row) == len(header)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise unreadable(path, error) from error
    if all(_number(cell, decimal) is not None for cell in header):
        raise Refused(path, "has no header: its first row holds numbers", "begin it with a row of columns' names")
    units_row = bool(table) and all(_number(cell, decimal) is None for cell in table[0])
    if len(table) - units_row < 2:
        raise Refused(path, "has a header and no two rows of numbers", "record longer")
    columns: dict[str, Array] = {}
    texts = []
    for name, cells in zip(header, zip(*table[units_row:], strict=True), strict=True):
        values = [_number(cell, decimal) for cell in cells]
        if sum(value is None for value in values) > len(values) / 2:
            texts.append(name)
        else:
            columns[name] = np.array([np.nan if value is None else value for value in values])
    written = CsvFormat(separator=separator, decimal=decimal)
    return LogContents(columns=columns, texts=tuple(texts), written=written, units_row=units_row)


def _written(head: list[str]) -> tuple[str, str]:
    """What parts the columns and what stands before decimals: what parts the first lines alike, and most often."""
    counts = {s: head[0].count(s) for s in (",", *(s for s, _ in SEPARATORS))}
    separator = max(counts, key=lambda s: (min(line.count(s) for line in head[1:-1] or head), counts[s]))
    if separator != "," and any("," in line for line in head[1:3]) and not any("." in line for line in head[1:3]):
        return separator, ","
    return separator, "."


def _number(cell: str, decimal: str) -> float | None:
    if "_" in cell:
        return None
    text = cell.strip().replace(decimal, ".") if decimal != "." else cell.strip()
    if not text:
        return np.nan
    try:
        return float(text)
    except ValueError:
        return None
