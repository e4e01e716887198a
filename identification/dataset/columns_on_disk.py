"""Columns of a series that lie in a file, for series that are written or exported and are too long for memory."""

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

_BYTES = 8


class ColumnOnDisk:
    """A column (T,) that slices are read from: `column[3:7]`, and `np.asarray(column)` for all of it."""

    def __init__(self, handle: int, first: int, rows: int) -> None:
        """handle: of the open file; first: number of the column's first value in it."""
        self._handle, self._first, self._rows = handle, first, rows

    def __len__(self) -> int:
        return self._rows

    def __getitem__(self, part: slice) -> Array:
        begin, end, step = part.indices(self._rows)
        raw = os.pread(self._handle, _BYTES * max(end - begin, 0), _BYTES * (self._first + begin))
        return np.frombuffer(raw, dtype=float)[::step]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self[:], dtype=dtype)


class SeriesOnDisk:
    """A series in a file without a name, which goes with it; written part after part."""

    def __init__(self, folder: Path, max_rows: int) -> None:
        """folder: where the file is, on a disk that has room for it. Raises Refused where it cannot be made."""
        self._time, self._names, self._max_rows = list[Array](), list[str](), max_rows
        try:
            self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115, it lives as long as the series
        except OSError as error:
            raise Refused(folder, f"cannot be written ({error.strerror})") from error

    def write(self, part: Series) -> None:
        """The next rows. Every part has the same columns."""
        first = sum(map(len, self._time))
        if first + len(part) > self._max_rows:
            raise ValueError(f"more than {self._max_rows} rows")
        self._time.append(part.time)
        self._names = self._names or list(part.columns)
        for k, name in enumerate(self._names):
            values = np.ascontiguousarray(part.columns[name], dtype=float)
            try:
                os.pwrite(self._file.fileno(), values.tobytes(), _BYTES * (k * self._max_rows + first))
            except OSError as error:
                raise Refused(
                    "the disk of --out", f"cannot be written ({error.strerror})", "make room on it"
                ) from error

    def series(self) -> Series:
        """The series, once it is written. Its columns can be sliced, and become arrays where they are asked for whole."""
        time = np.concatenate(self._time)
        columns = [ColumnOnDisk(self._file.fileno(), k * self._max_rows, len(time)) for k in range(len(self._names))]
        return _Held(time, dict(zip(self._names, cast(Sequence[Array], columns), strict=True)), self)


class _Held(Series):
    """A series that keeps the file open which its columns are in."""

    def __init__(self, time: Array, columns: dict[str, Array], of: SeriesOnDisk) -> None:
        super().__init__(time, columns)
        object.__setattr__(self, "_of", of)
