"""Parquet files, read by column name through pyarrow, which the extra `parquet` brings."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from identification.dataset.series import Array, Series
from xneck_foundation.errors import Refused
from xneck_foundation.extras import needs_extra
from xneck_foundation.input_file import check_input
from xneck_foundation.one_line import listed
from xneck_foundation.spelling import valid_words

MAX_VALUES = 200_000_000
"""most values of the columns that are read: a day at 500 Hz of one motor has 130 million; a small file can claim any number"""


def read_parquet(
    path: Path, required: Sequence[str], optional: Sequence[str] = (), time_column: str = "time"
) -> Series:
    """The time's column, all of `required`, and those of `optional` that the file has; stamps become seconds, nulls NaN.

    Raises Refused where pyarrow is missing, columns lack, or are no numbers.
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
    """All columns that are numbers or stamps, by name; stamps in seconds."""
    import pyarrow.types as kinds

    fields = _open(path).schema_arrow
    wanted = [
        f.name
        for f in fields
        if kinds.is_integer(f.type)
        or kinds.is_floating(f.type)
        or kinds.is_boolean(f.type)
        or kinds.is_timestamp(f.type)
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
        raise Refused(
            path, f"cannot be read as Parquet ({str(error).splitlines()[0]})", "is it a whole file?"
        ) from error


def _numbers(path: Path, names: Sequence[str]) -> dict[str, Array]:
    import pyarrow
    import pyarrow.types as kinds

    file = _open(path)
    if file.metadata.num_rows * len(names) > MAX_VALUES:
        raise Refused(path, f"has {file.metadata.num_rows} rows", "give a shorter recording")
    try:
        table = file.read(columns=list(names))
        found = {}
        for name in names:
            column = table.column(name)
            if kinds.is_timestamp(column.type):
                stamps = column.cast(pyarrow.timestamp("ns")).cast(pyarrow.int64())
                found[name] = stamps.to_numpy(zero_copy_only=False).astype(float) / 1e9
            else:
                found[name] = column.cast(pyarrow.float64()).to_numpy(zero_copy_only=False).astype(float)
    except (pyarrow.ArrowException, OSError, ValueError, KeyError) as error:
        what = f"columns {listed(names)} cannot be read as numbers ({str(error).splitlines()[0]})"
        raise Refused(path, what, "name columns of numbers in neck.yaml") from error
    return {name: np.ascontiguousarray(values) for name, values in found.items()}
