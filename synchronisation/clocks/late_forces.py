"""The clock where forces come late by much more than a motor's current needs: delayed, or through a motor that lags.

The clock's equations take a delay to first order, which holds for a millisecond or two. A motor that answers its command by a
first-order lag of 10 ms bends the clock by about one. So the forces of the log are made late by what was found, in both ways, and
the clock is fitted again, until what is left of the delay is small.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from identification.dataset.series import Series, interpolated, numbered_columns
from synchronisation.clocks.fine_alignment import MAX_MISFIT_RATIO, FineAlignment, clock_misfit
from synchronisation.clocks.signals import LogSignals
from synchronisation.clocks.undetermined import ClockUndetermined
from synchronisation.clocks.unknowns import ClockUnknowns

LINEAR_DELAY_S = 2e-3
"""s: a longer delay is not left to the equations' first order (docs/thresholds.md)"""
SETTLED_DELAY_S = 1e-4
"""s: forces are late enough once they would have to be later by less (docs/thresholds.md)"""
SECANT_RANGE = (-0.5, 2.0)
"""share of the last step that the next one may be"""
MAX_ROUNDS = 6
"""times that forces are made later with one set of assumptions"""
MAX_ALIGNMENTS = 3
"""times that the assumptions are chosen anew, with forces as late as they were found to be"""
RIVAL_MISFIT_RATIO = 2.0
"""a lag and a delay are both looked at closely where the one's misfit is at most so many times the other's (docs/thresholds.md)"""

Aligning = Callable[[LogSignals, FineAlignment], FineAlignment]
"""the clock by other signals of the log, from a start"""
Refitting = Callable[[LogSignals, FineAlignment], ClockUnknowns]
"""a fit to other signals of the log with all that another one assumes"""


def with_acting_forces(series: Series, delay: float) -> Series:
    """A series with forces where they act, `delay` s after the rows that say them; a delay that equations take as it is stays."""
    f = series.matrix("f")
    if abs(delay) <= LINEAR_DELAY_S or not f.shape[1]:
        return series
    return Series(
        series.time, {**series.columns, **numbered_columns("f", interpolated(series.time - delay, series.time, f))}
    )


def despite_late_forces(
    signals: LogSignals, fine: FineAlignment, aligned: Aligning, refitted: Refitting
) -> FineAlignment:
    """The clock with forces as late as they are; `fine`: by `signals` as they were logged.

    Of a lag and of a delay the one is taken that explains the recording better; where the other does about as well, sigma holds
    how far the two are apart."""
    if abs(fine.delay) < LINEAR_DELAY_S:
        return fine
    first = [late for smeared in (True, False) if (late := _settled(signals, fine, 0.0, refitted, smeared)) is not None]
    least = min((late.misfit for late in first), default=0.0)
    found = list[FineAlignment]()
    for late in first:
        if late.misfit < RIVAL_MISFIT_RATIO * least:
            with suppress(ClockUndetermined):
                found.append(_aligned(signals, fine, late, aligned, refitted))
    best, *others = sorted([fine, *found], key=_misfit)
    apart = [abs(o.offset - best.offset) for o in others if _misfit(o) < MAX_MISFIT_RATIO * _misfit(best)]
    return replace(best, offset_sigma=float(np.hypot(best.offset_sigma, max(apart, default=0.0))))


@dataclass(frozen=True)
class _Late:
    """Forces that lag (`smeared`) or are delayed by `lateness`, s, and what a fit with them leaves."""

    smeared: bool
    lateness: float
    misfit: float


def _aligned(
    signals: LogSignals, fine: FineAlignment, found: _Late, aligned: Aligning, refitted: Refitting
) -> FineAlignment:
    """The clock with late forces, its assumptions chosen anew. Raises ClockUndetermined where the fit leaves its start."""
    for alignment in range(MAX_ALIGNMENTS):
        fine = aligned(signals.late(found.lateness, found.smeared), fine)
        if abs(fine.delay) < SETTLED_DELAY_S or alignment == MAX_ALIGNMENTS - 1:
            break
        # other assumptions now explain it, and with them forces are otherwise late
        found = _settled(signals, fine, found.lateness, refitted, found.smeared) or found
    return replace(fine, delay=found.lateness + fine.delay)


def _settled(
    signals: LogSignals, fine: FineAlignment, lateness: float, refitted: Refitting, smeared: bool
) -> _Late | None:
    """How late forces are with all that a fit to forces late by `lateness`, s, assumes; None where none such is found."""
    step = left = fine.delay
    misfit = np.inf
    for _ in range(MAX_ROUNDS):
        lateness += step
        if smeared and lateness <= 0:
            return None
        try:
            unknowns = refitted(signals.late(lateness, smeared), fine)
        except ClockUndetermined:
            return None
        left_before, left, misfit = left, unknowns.delay, clock_misfit(unknowns)
        if abs(left) < SETTLED_DELAY_S:
            break
        # a lag does less than a delay as long: by the secant, held to where it may be trusted
        step *= float(np.clip(left / (left_before - left), *SECANT_RANGE)) if left_before != left else 1.0
    return _Late(smeared, lateness, misfit)


def _misfit(fine: FineAlignment) -> float:
    return clock_misfit(fine.fit.unknowns)
