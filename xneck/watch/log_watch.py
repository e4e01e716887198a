"""A log watched while it grows: what is wrong with it by itself, and its newest rows for whoever compares them."""

import numpy as np

from identification.dataset.series import Series
from mechanism.description import Neck
from xneck.watch.finding import Finding
from xneck.watch.growing_file import GrowingFile
from xneck.watch.growing_log import GrowingLog
from xneck.watch.log_findings import MIN_ROWS, gap_findings, refused_finding, stopped_finding, time_finding
from xneck_foundation.errors import Refused

GAP_ROWS_S = 12.0
"""s of log that are looked through for gaps"""


class LogWatch:
    """The rows of a log as they come, and what they say."""

    def __init__(self, source: GrowingFile, neck: Neck) -> None:
        self.path = source.path
        self._log = GrowingLog(source, neck)
        self._gap_after = -np.inf
        self.is_readable = True
        """whether it may be this arm's log"""
        self._time_is_sound = False

    @property
    def rows(self) -> int:
        """Number of rows so far."""
        return self._log.rows

    @property
    def newest_s(self) -> float:
        """Time of the newest row, s; NaN where there is none."""
        return self._log.newest_s

    @property
    def can_be_compared(self) -> bool:
        """Whether its rows and their times are sound."""
        return self.is_readable and self._time_is_sound

    def since(self, time: float) -> Series | None:
        """The kept rows from `time` on, s."""
        return self._log.since(time)

    def poll(self) -> tuple[bool, list[Finding]]:
        """Reads what is new: whether there is any, and what is wrong."""
        if not self.is_readable:
            return False, []
        try:
            grew = self._log.poll()
        except Refused as refusal:
            self.is_readable = False
            return False, [refused_finding("log", refusal, self.newest_s if self.rows else 0.0)]
        return grew, self._new_rows_findings() if grew else []

    def silence_findings(self, silent_s: float, longest_s: float | None) -> list[Finding]:
        """Where the video grows and the log has not for `silent_s`, and for `longest_s` at most before."""
        if not self.is_readable:
            return []
        stopped = stopped_finding(silent_s, longest_s, self.newest_s, self.path.suffix.lower() == ".mcap")
        return [] if stopped is None else [stopped]

    def _new_rows_findings(self) -> list[Finding]:
        if not self._time_is_sound:
            rows = self.since(-np.inf)
            if rows is None or len(rows) < MIN_ROWS:
                return []
            if (finding := time_finding(rows, str(self.path))) is not None:
                self.is_readable = False
                return [finding]
            self._time_is_sound = True
        rows = self.since(self.newest_s - GAP_ROWS_S)
        if rows is None:
            return []
        gaps = gap_findings(rows, self._gap_after)
        self._gap_after = max([self._gap_after, *(gap.onset_s for gap in gaps)])
        return gaps
