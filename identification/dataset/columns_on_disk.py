"""Columns of a series that lie in a file, for series that are written or exported and are too long for memory."""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

_BYTES = 8


class ColumnOnDisk:
    """A column (T,) that slices are read from: `column[3:7]`, and `np.asarray(column)` for all of it."""

    def __init__(self, file: BinaryIO, first: int, rows: int) -> None:
        """first: number of the column's first value in the file."""
        self._file, self._first, self._rows = file, first, rows

    def __len__(self) -> int:
        return self._rows

    def __getitem__(self, part: slice) -> Array:
        begin, end, step = part.indices(self._rows)
        self._file.seek(_BYTES * (self._first + begin))
        return np.frombuffer(self._file.read(_BYTES * max(end - begin, 0)), dtype=float)[::step]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self[:], dtype=dtype)


class SeriesOnDisk:
    """A series in a file without a name, which goes with it; written part after part."""

    def __init__(self, folder: Path, max_rows: int) -> None:
        """folder: where the file is, on a disk that has room for it. Raises Refused where it cannot be made."""
        self._folder, self._time, self._names, self._max_rows = folder, list[Array](), list[str](), max_rows
        with self._on_disk():
            self._file = cast(BinaryIO, tempfile.TemporaryFile(dir=folder))  # noqa: SIM115, it lives as long as the series

    def write(self, part: Series) -> None:
        """The next rows. Every part has the same columns. Raises Refused where the disk is full."""
        first = sum(map(len, self._time))
        if first + len(part) > self._max_rows:
            raise ValueError(f"more than {self._max_rows} rows")
        self._time.append(part.time)
        self._names = self._names or list(part.columns)
        with self._on_disk():
            for k, name in enumerate(self._names):
                self._file.seek(_BYTES * (k * self._max_rows + first))
                self._file.write(np.ascontiguousarray(part.columns[name], dtype=float).tobytes())
            self._file.flush()

    def series(self) -> Series:
        """The series, once it is written. Its columns can be sliced, and become arrays where they are asked for whole."""
        time = np.concatenate(self._time)
        columns = [ColumnOnDisk(self._file, k * self._max_rows, len(time)) for k in range(len(self._names))]
        return Series(time, dict(zip(self._names, cast(Sequence[Array], columns), strict=True)))

    @contextmanager
    def _on_disk(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise Refused(self._folder, f"cannot be written ({error.strerror})", "make room there") from error
