"""What is wrong with a log whatever the video shows: its time, rows that are missing, and that it no longer grows."""

import numpy as np

from identification.dataset.series import Series, check_time
from identification.dataset.time_unit import check_time_unit
from synchronisation.clocks.log_gaps import repair_log
from synchronisation.row_order import kept_rows
from synchronisation.time_stamps import check_log_rate
from xneck.watch.finding import Finding
from xneck_foundation.errors import Refused

MIN_ROWS = 100
"""rows from which on the unit of time is judged (docs/thresholds.md)"""
STOPPED_S, STOPPED_RATIO = 3.0, 2.0
"""s without a new row, and ratio of that to the longest such time before, from which on a log has stopped (docs/thresholds.md)"""
CHUNK_S = 20.0
"""s for which an MCAP may not grow at first: writers collect rows to chunks (docs/thresholds.md)"""


def time_finding(rows: Series, where: str) -> Finding | None:
    """Whether the time of a log's first rows is in seconds, increases, and often enough."""
    if len(rows) < MIN_ROWS:
        return None
    rows = rows.part(kept_rows(rows))
    try:
        check_time_unit(rows.time, where, "rows")
        check_time(rows.time, where)
        check_log_rate(rows.time, where)
    except Refused as refusal:
        return refused_finding("log", refusal, float(rows.time[0]))
    return None


def gap_findings(rows: Series, after: float) -> list[Finding]:
    """Rows that are missing, or repeat one sample, in the newest part of a log; only gaps that begin after a time, s."""
    rows = rows.part(kept_rows(rows))
    if len(rows) < MIN_ROWS or np.any(np.diff(rows.time) <= 0):
        return []
    findings = []
    for begin, end in repair_log(rows).gaps:
        if begin > after:
            what = f"the log has no true row for {end - begin:.3g} s after {begin:.2f} s"
            do = "does the controller keep up with its logging? Log to a faster disk, or from a thread of its own"
            findings.append(Finding("log_gap", begin, "log", what, do, f"{begin:.3f} s"))
    return findings


def stopped_finding(silent_s: float, longest_s: float | None, newest_s: float, in_chunks: bool) -> Finding | None:
    """Whether a log has stopped that has not grown for `silent_s`, and for `longest_s` at most before (None: never grew twice)."""
    usual = longest_s if longest_s is not None else (CHUNK_S / STOPPED_RATIO if in_chunks else 0.0)
    if silent_s < max(STOPPED_S, STOPPED_RATIO * usual):
        return None
    return Finding(
        kind="log_stopped",
        onset_s=newest_s,
        clock="log",
        what=f"the log has not grown for {silent_s:.0f} s while the video goes on",
        do="does the controller still run?",
        where=f"{newest_s:.3f} s",
    )


def refused_finding(kind: str, refusal: Refused, onset_s: float) -> Finding:
    """A refusal that `run` would end with, as a finding."""
    return Finding(kind, onset_s, "camera" if kind == "video" else "log", refusal.what, refusal.do)
