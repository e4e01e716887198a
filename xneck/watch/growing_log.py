"""The newest part of a log that is being written, as the file has it."""

import numpy as np

from identification.dataset.series import Series, concatenated
from mechanism.description import Neck
from xneck.watch.csv_rows import CsvRows
from xneck.watch.growing_file import GrowingFile
from xneck.watch.mcap_rows import McapRows

MAX_ROWS = 60_000
"""newest rows that are kept: two minutes at 500 Hz"""


class GrowingLog:
    """Rows of a log as they come."""

    def __init__(self, source: GrowingFile, neck: Neck) -> None:
        self.source = source
        kind = McapRows if source.path.suffix.lower() == ".mcap" else CsvRows
        self._rows = kind(source, neck)
        self._parts: list[Series] = []
        self.rows = 0
        """number of rows so far"""

    def poll(self) -> bool:
        """Whether new rows came. Raises Refused where the log cannot be one of this arm."""
        grew = False
        while (part := self._rows.new()) is not None:
            if self._parts and self._parts[0].columns.keys() != part.columns.keys():
                self._parts.clear()
            self._parts.append(part)
            self.rows += len(part)
            grew = True
        while len(self._parts) > 1 and sum(map(len, self._parts[1:])) >= MAX_ROWS:
            del self._parts[0]
        return grew

    @property
    def newest_s(self) -> float:
        """Time of the newest row, s; NaN where there is none."""
        return float(self._parts[-1].time[-1]) if self._parts else float("nan")

    def since(self, time: float) -> Series | None:
        """The kept rows from `time` on, s, in the file's own units; None where there are fewer than two."""
        if not self._parts:
            return None
        parts = [part for part in self._parts if part.time[-1] >= time]
        if not parts:
            return None
        rows = concatenated(parts)
        rows = rows.part(np.asarray(rows.time >= time))
        return rows if len(rows) > 1 else None
