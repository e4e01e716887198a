"""The clock where forces come late by much more than a motor's current needs: delayed, or through a motor that lags.

The clock's equations take a delay to first order, which holds for a millisecond or two. A motor that answers its command by a
first-order lag of 10 ms bends the clock by about one. So the forces of the log are made late by what was found, in both ways, and
the clock is fitted again, until what is left of the delay is small.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from synchronisation.clocks.fine_alignment import MAX_MISFIT_RATIO, FineAlignment, clock_misfit
from synchronisation.clocks.signals import LogSignals
from synchronisation.clocks.undetermined import ClockUndetermined

LINEAR_DELAY_S = 2e-3
"""s: a longer delay is not left to the equations' first order (docs/thresholds.md)"""
SETTLED_DELAY_S = 1e-4
"""s: forces are late enough once they would have to be later by less (docs/thresholds.md)"""
SECANT_RANGE = (-0.5, 2.0)
"""share of the last step that the next one may be"""
MAX_ROUNDS = 6
"""times that forces are made later"""

Aligning = Callable[[LogSignals, float], FineAlignment]
"""the clock by other signals of the log, from a start of the offset, s"""


def despite_late_forces(signals: LogSignals, fine: FineAlignment, aligned: Aligning) -> FineAlignment:
    """The clock with forces as late as they are; `fine`: by `signals` as they were logged.

    Of a lag and of a delay the one is taken that explains the recording better; where the other does about as well, sigma holds
    how far the two are apart."""
    if abs(fine.delay) < LINEAR_DELAY_S:
        return fine
    found = [late for smeared in (True, False) if (late := _late(signals, fine, aligned, smeared)) is not None]
    if not found:
        return fine
    best, *others = sorted(found, key=_misfit)
    apart = [abs(o.offset - best.offset) for o in others if _misfit(o) < MAX_MISFIT_RATIO * _misfit(best)]
    return replace(best, offset_sigma=float(np.hypot(best.offset_sigma, max(apart, default=0.0))))


def _late(signals: LogSignals, fine: FineAlignment, aligned: Aligning, smeared: bool) -> FineAlignment | None:
    """The clock with forces that lag (`smeared`) or are delayed; None where none is found, or it explains no better."""
    late, lateness, step, left = fine, 0.0, fine.delay, fine.delay
    for _ in range(MAX_ROUNDS):
        lateness += step
        if smeared and lateness <= 0:
            return None
        try:
            late = aligned(signals.late(lateness, smeared), late.offset)
        except ClockUndetermined:
            return None
        left_before, left = left, late.delay
        late = replace(late, delay=lateness + left)
        if abs(left) < SETTLED_DELAY_S:
            break
        # a lag does less than a delay as long: by the secant, held to where it may be trusted
        step *= float(np.clip(left / (left_before - left), *SECANT_RANGE)) if left_before != left else 1.0
    return late if _misfit(late) < _misfit(fine) else None


def _misfit(fine: FineAlignment) -> float:
    return clock_misfit(fine.fit.unknowns)
