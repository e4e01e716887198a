"""Rows of the log that are missing, or that repeat one sample while the motors moved on."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series, clear_of_gaps
from identification.dataset.true_rows import sampled_rows
from synchronisation.time_stamps import row_numbers

Array = NDArray[np.float64]

MIN_GAP_S = 0.01
"""s without a true row that make a gap; shorter ones are bridged (docs/thresholds.md)"""
LONG_GAP_S = 0.5
"""s without a true row from which on a person is told of a gap (docs/thresholds.md)"""
MIN_REPEATED_SHARE = 0.01
"""of the rows: from there on a person is told that they repeat (docs/thresholds.md)"""
MIN_GAP_STEPS = 1.5
"""steps of the log between two rows that make a gap, however slow the log is: a row is missing (docs/thresholds.md)"""


@dataclass(frozen=True)
class RepairedLog:
    """The log without repeated samples, and the spans in which it holds nothing true."""

    log: Series
    repeated_rows: int
    missing_rows: int
    """rows that are missing between two stamps"""
    gaps: tuple[tuple[float, float], ...]
    """begin and end of spans wider than MIN_GAP_S and MIN_GAP_STEPS, s, log clock"""

    def clear_of_gaps(self, time: Array, margin: float) -> NDArray[np.bool_]:
        """Which log times (T,), s, are at least `margin` s away from every gap."""
        return clear_of_gaps(time, self.gaps, margin)

    def warnings(self) -> tuple[str, ...]:
        """Of repeated rows, and of gaps of LONG_GAP_S and more: where the first is, how many there are, and how long they last."""
        return (*self._of_repeated_rows(), *self._of_gaps())

    def _of_repeated_rows(self) -> tuple[str, ...]:
        rows = len(self.log) + self.repeated_rows
        if self.repeated_rows < MIN_REPEATED_SHARE * rows:
            return ()
        return (
            f"{self.repeated_rows} of {rows} rows of the log repeat the one before, all columns, while motors moved on: "
            "they are left out; write a row when the drive has a new sample",
        )

    def _of_gaps(self) -> tuple[str, ...]:
        long = [(begin, end) for begin, end in self.gaps if end - begin >= LONG_GAP_S]
        if not long:
            return ()
        (begin, end), seconds = long[0], sum(end - begin for begin, end in long)
        others = f", and {len(long) - 1} more, {seconds:.1f} s in all" if len(long) > 1 else ""
        return (f"gaps of the log: no rows from {begin:.2f} to {end:.2f} s{others}; frames there are left out",)


def repair_log(log: Series) -> RepairedLog:
    """Drops repeated samples (the first of each is true) and finds the gaps."""
    true = sampled_rows(log)
    repaired = log if true.all() else log.part(true)
    step = float(np.median(np.diff(log.time)))
    between = np.diff(repaired.time)
    # where rows repeat each sample several times the log is as slow as its samples
    gaps = np.flatnonzero(between > max(MIN_GAP_S, MIN_GAP_STEPS * float(np.median(between))))
    return RepairedLog(
        log=repaired,
        repeated_rows=int(np.sum(~true)),
        missing_rows=int(row_numbers(log.time, step)[-1]) - (len(log) - 1),
        gaps=tuple((float(repaired.time[k]), float(repaired.time[k + 1])) for k in gaps),
    )
