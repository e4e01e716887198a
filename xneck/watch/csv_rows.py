"""The rows of a log as CSV while it is written: whole lines only, as the last one may be half."""

import csv

import numpy as np

from identification.dataset.series import Series
from mechanism.description import Neck
from synchronisation.csv_cell import unit_in
from synchronisation.csv_layout import COMMENT
from synchronisation.csv_table import row_numbers, table_columns, unreadable
from synchronisation.encoder_log import check_column_units, check_columns, csv_format, log_columns, mapped_columns
from synchronisation.text_encoding import encoding_of
from xneck.watch.growing_file import GrowingFile
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import shortened

_BLOCK_BYTES = 1 << 20


class CsvRows:
    """New rows of a growing CSV."""

    def __init__(self, source: GrowingFile, neck: Neck) -> None:
        self._source, self._neck = source, neck
        self._rest = b""
        self._encoding = ""
        self._header: list[str] = []
        self._written = csv_format(neck)
        self._places: dict[str, int] | None = None
        self._lines_read = 0
        self._units_awaited = self._written.units_row
        self._units: dict[str, str] = {}

    def new(self) -> Series | None:
        """Rows that came since the last call, in columns theta, f and led; None where none did.

        Raises Refused as `read_log` does.
        """
        data = self._rest + self._source.read_available(_BLOCK_BYTES)
        whole, newline, self._rest = data.rpartition(b"\n")
        if not newline:
            return None
        self._encoding = self._encoding or encoding_of(whole)
        try:
            lines = (whole + newline).decode(self._encoding).splitlines()
            numbered = [
                (k, line)
                for k, line in enumerate(lines, self._lines_read + 1)
                if line.strip() and not line.startswith(COMMENT)
            ]
            self._lines_read += len(lines)
            if not self._header and numbered:
                (_, header), *numbered = numbered
                self._header = [cell.strip() for cell in next(csv.reader([header], delimiter=self._written.separator))]
            if self._header and self._units_awaited and numbered:
                (_, units), *numbered = numbered
                self._units_awaited = False
                cells = next(csv.reader([units], delimiter=self._written.separator))
                self._units = dict(zip(self._header, map(unit_in, cells), strict=False))
            rows = list(csv.reader([line for _, line in numbered], delimiter=self._written.separator))
        except (UnicodeDecodeError, csv.Error) as error:
            raise unreadable(self._source.path, error) from error
        if not rows:
            return None
        if self._places is None:
            required, optional = log_columns(self._neck)
            path = self._source.path
            check_column_units(path, self._neck, self._units)
            self._places = table_columns(
                path, self._header, iter(rows[:1]), (self._written.time_column, *required), optional
            )
            check_columns(path, self._places, self._neck)
        values = np.array([self._numbers(line, row) for (line, _), row in zip(numbered, rows, strict=True)])
        series = Series(values[:, 0], {name: values[:, k] for k, name in enumerate(self._places) if k})
        return mapped_columns(series, self._neck)

    def _numbers(self, line: int, row: list[str]) -> list[float]:
        assert self._places is not None
        try:
            if len(row) != len(self._header):
                raise ValueError
            cells = [row[k] for k in self._places.values()]
            if self._written.decimal != ".":
                cells = [cell.replace(self._written.decimal, ".") for cell in cells]
            return row_numbers(cells)
        except ValueError:
            shown = shortened(",".join(row), 60)
            raise Refused(self._source.path, f"row {line} is not {len(self._header)} numbers: {shown}") from None
