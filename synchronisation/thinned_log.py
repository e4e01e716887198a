"""Logs that keep one row of several control steps: their forces are samples, not what was held until the next row.

All else takes the force of a row as held until the next one. In a log that was thinned it is held for one control step only, so
that it seems to act before its row, by up to half the time between two rows: no controller does that.
"""

import numpy as np

from identification.dataset.series import Series, numbered_columns
from synchronisation.clocks.clock_estimate import ClockEstimate

MIN_ROW_S = 3e-3
"""s between rows from which on a thinned log is thought of: what is left out of a denser one does no harm (docs/thresholds.md)"""
MIN_LEAD_RATIO = 0.15
"""ratio to the time between rows by which forces must seem to act too early (docs/thresholds.md)"""
MIN_LEAD_SIGMA = 5.0
"""the same lead in its standard deviations (docs/thresholds.md)"""


def rows_left_out(log: Series, clock: ClockEstimate) -> bool:
    """Whether the clock's fit says that the log holds one of several control steps."""
    row = _row(log)
    if clock.delay is None or row < MIN_ROW_S:
        return False
    delay, sigma = clock.delay
    return delay < -max(MIN_LEAD_RATIO * row, MIN_LEAD_SIGMA * sigma)


def rows_left_out_warning(log: Series, clock: ClockEstimate) -> str:
    """The same in words."""
    lead = -1e3 * clock.delay[0] if clock.delay else 0.0
    return (
        f"the log seems to keep one row of several control steps (its forces act {lead:.1f} ms before their rows, which are "
        f"{1e3 * _row(log):.3g} ms apart): forces are taken as samples; log every step"
    )


def forces_held(log: Series, clock: ClockEstimate) -> Series:
    """The log with forces as if they had been held until the next row: moved by their lead, between each sample and the next."""
    assert clock.delay is not None
    f, share = log.matrix("f"), min(-clock.delay[0] / _row(log), 1.0)
    return Series(
        log.time, {**log.columns, **numbered_columns("f", (1 - share) * f + share * np.vstack([f[1:], f[-1:]]))}
    )


def _row(log: Series) -> float:
    """s from row to row."""
    return float(np.median(np.diff(log.time)))
