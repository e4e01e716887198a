"""Parquet files, read by column name through pyarrow, which the extra `parquet` brings."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from identification.dataset.series import Array, Series
from xneck_foundation.errors import Refused
from xneck_foundation.extras import needs_extra
from xneck_foundation.input_file import check_input
from xneck_foundation.spelling import quoted, valid_words

MAX_VALUES = 200_000_000
"""most values of the columns that are read: a day at 500 Hz of one motor has 130 million; a small file can claim any number"""


def read_parquet(
    path: Path, required: Sequence[str], optional: Sequence[str] = (), time_column: str = "time"
) -> Series:
    """The time's column, all of `required`, and those of `optional` that the file has.

    Stamps and durations become seconds, nulls NaN. Raises Refused where pyarrow is missing, a column lacks, or is no numbers.
    """
    names = parquet_columns(path)
    for name in (time_column, *required):
        if name not in names:
            raise Refused(path, f"lacks the column {name}", f"{valid_words(name, names)}; name it in neck.yaml")
    wanted = [time_column, *required, *(name for name in optional if name in names)]
    columns = _numbers(path, wanted)
    return Series(columns.pop(time_column), columns)


def parquet_columns(path: Path) -> list[str]:
    """Names of a file's columns. Raises Refused where pyarrow is missing, or it is no such file."""
    return [field.name for field in _open(path).schema_arrow]


def numeric_columns(path: Path) -> dict[str, Array]:
    """All columns that are numbers, stamps or durations, by name; the last two in seconds."""
    import pyarrow.types as kinds

    fields = _open(path).schema_arrow
    wanted = [
        f.name
        for f in fields
        if kinds.is_integer(f.type)
        or kinds.is_floating(f.type)
        or kinds.is_boolean(f.type)
        or kinds.is_timestamp(f.type)
        or kinds.is_duration(f.type)
    ]
    return _numbers(path, wanted)


def _open(path: Path) -> Any:
    check_input(path)
    with needs_extra("parquet", "pyarrow", path):
        import pyarrow
        import pyarrow.parquet
    try:
        return pyarrow.parquet.ParquetFile(path)
    except (pyarrow.ArrowException, OSError) as error:
        raise Refused(path, f"cannot be read as Parquet ({_first_line(error)})", "is it a whole file?") from error


def _numbers(path: Path, names: Sequence[str]) -> dict[str, Array]:
    import pyarrow

    file = _open(path)
    held = file.schema_arrow.names
    if twice := [name for name in names if held.count(name) > 1]:
        raise Refused(path, f"has the column {quoted(twice[0])} {held.count(twice[0])} times", "name each column once")
    if file.metadata.num_rows * len(names) > MAX_VALUES:
        raise Refused(path, f"has {file.metadata.num_rows} rows", "give a shorter recording")
    try:
        table = file.read(columns=list(names))
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        raise Refused(path, f"cannot be read as Parquet ({_first_line(error)})", "is it a whole file?") from error
    return {name: _column_numbers(path, name, table.column(name)) for name in names}


def _column_numbers(path: Path, name: str, column: Any) -> Array:
    """One column as numbers, stamps and durations in seconds, nulls NaN."""
    import pyarrow
    import pyarrow.types as kinds

    try:
        scale = 1.0
        if kinds.is_timestamp(column.type) or kinds.is_duration(column.type):
            of_ns = pyarrow.timestamp("ns") if kinds.is_timestamp(column.type) else pyarrow.duration("ns")
            column, scale = column.cast(of_ns).cast(pyarrow.int64()), 1e9
        else:
            column = column.cast(pyarrow.float64())
        values = column.to_numpy(zero_copy_only=False).astype(float) / scale
    except (pyarrow.ArrowException, ValueError) as error:
        what = f"column {quoted(name)} cannot be read as numbers ({_first_line(error)})"
        raise Refused(path, what, "name columns of numbers in neck.yaml") from error
    return np.ascontiguousarray(values)


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__
