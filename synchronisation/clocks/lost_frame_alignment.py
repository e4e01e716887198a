"""The clock together with the frames that were lost without a trace.

Losses are first decoded with cables that were fitted to one short window, then again with the cables of the whole recording.
They are believed only where the clocks then run together, and where leaving them out explains less.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import LostFrames
from mechanism.arm import Arm
from synchronisation.clocks.alternative_arms import check_alternative_arms
from synchronisation.clocks.cable_equation import CableEquation
from synchronisation.clocks.coarse_alignment import CableSpeeds, CoarseAlignment, shift_near
from synchronisation.clocks.fine_alignment import (
    MAX_MISFIT_RATIO,
    REPORTED,
    FineAlignment,
    align_finely,
    clock_misfit,
    refitted_to,
)
from synchronisation.clocks.frame_geometry import FrameGeometry
from synchronisation.clocks.gauss_newton_fit import LINEAR, ClockProblem, ClockSolution, fit_cables
from synchronisation.clocks.gauss_newton_step import SKEW_SIGMA
from synchronisation.clocks.late_forces import despite_late_forces
from synchronisation.clocks.log_gaps import RepairedLog
from synchronisation.clocks.lost_frames import decode_lost_frames, lost_frames_of, skew_despite_losses
from synchronisation.clocks.signals import LogSignals
from synchronisation.clocks.undetermined import ClockUndetermined
from synchronisation.clocks.usable_frames import EDGE_S, MIN_FRAMES, usable_frames
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

QUARTZ_SCALE = 0.1
"""of SKEW_SIGMA: how far clocks run apart where cables and arm would have them run apart as none do (docs/thresholds.md)"""
MAX_SKEW = 4 * SKEW_SIGMA
"""ratio: a fit that comes to more has not found the motion (docs/thresholds.md)"""
MAX_RESIDUAL_M = 2e-3
"""m, RMS over all cables: more is left only where neck.yaml is of another arm (docs/thresholds.md)"""
WINDOW_S = 4.0
"""s of the windows in which cables are first fitted, short enough to be without losses (docs/thresholds.md)"""
MAX_WINDOWS = 10
"""windows that are tried, the liveliest first (docs/thresholds.md)"""
MAX_WINDOW_SHIFT_S = 2.0
"""s by which lost frames may have moved a window from the coarse alignment (docs/thresholds.md)"""
WINDOW_CABLE_ERROR_M = 3e-4
"""m: how well cables are known from one window while losses are decoded (docs/thresholds.md)"""
DECODING_CABLE_ERROR_M = 5e-5
"""m: how well cables are known at best from the whole recording while losses are decoded (docs/thresholds.md)"""
INDEPENDENT_ERRORS_HZ = 30.0
"""Hz: errors of the cables' law last so long that frames of a faster camera share them (docs/thresholds.md)"""

TOO_SLOW = "whether frames were lost is not told: the motion is too slow, or cables do not follow it as described"
GAPS = "gaps of the log leave open whether frames were lost"


@dataclass(frozen=True)
class AlignedMotion:
    """Frames and log of one motion, coarsely aligned."""

    arm: Arm
    signals: LogSignals
    repaired: RepairedLog
    frames: FrameGeometry
    """all of them, at their stamps"""
    period: float
    """s: the camera's period by the stamps"""
    fv: Array
    """(M,), N s/rad, NaN where not known"""
    video_speeds: CableSpeeds
    log_speeds: CableSpeeds
    coarse: CoarseAlignment

    @property
    def no_loss(self) -> LostFrames:
        """The record of a recording that lost no frame."""
        return LostFrames(period=self.period)

    def usable(self, lost: LostFrames, offset: float) -> FrameGeometry:
        """The frames within the log at their true times, given the losses and a rough offset, s."""
        return usable_frames(self.frames, self.signals, self.repaired, lost, offset)

    def aligned(self, lost: LostFrames, offset: float, skew_scale: float = 1.0) -> FineAlignment:
        """The clock with these losses, from a start of the offset, s. Raises ClockUndetermined where the fit leaves it."""
        return align_finely(self.arm, self.signals, self.usable(lost, offset), offset, self.fv, skew_scale)

    def aligned_or_none(self, lost: LostFrames, offset: float, skew_scale: float = 1.0) -> FineAlignment | None:
        """The clock with these losses, None where the fit leaves its start."""
        try:
            return self.aligned(lost, offset, skew_scale)
        except ClockUndetermined:
            return None

    def check_alternative_arms(self, lost: LostFrames, *offsets: float) -> None:
        """Refused where the cables of another arm fit better, from any of the offsets, s: with these losses, and without any.

        Losses that laws of another form feign leave much unexplained of the right arm."""
        problem = ClockProblem(self.signals, self.usable(lost, offsets[0]), self.fv)
        try:
            check_alternative_arms(self.arm, problem, offsets, REPORTED.law)
        except Refused:
            if not lost.losses:
                raise
            self.check_alternative_arms(self.no_loss, self.coarse.shift)


def align_with_lost_frames(motion: AlignedMotion) -> tuple[LostFrames, FineAlignment, list[str]]:
    """Frames lost without a trace, the clock with them, and warnings.

    Raises ClockUndetermined where no fit succeeds or its result is impossible, Refused where another arm fits better."""
    shift = motion.coarse.shift
    lost, start = _losses_by_window(motion)
    fine = motion.aligned_or_none(lost, start)
    too_slow = fine is None
    if fine is None:
        lost, fine = motion.no_loss, _aligned_without_losses(motion)
    motion.check_alternative_arms(lost, fine.fit.unknowns.offset, shift)
    if not too_slow:
        lost_again = _losses_by_whole(motion.frames, fine, lost)
        again = motion.aligned_or_none(lost_again, fine.fit.unknowns.offset) if lost_again != lost else None
        lost, fine = (lost, fine) if again is None else (lost_again, again)
    if lost.losses:
        # a slow motion feigns losses that make the clocks run apart, and cables that creep from where they were pulled feign one
        without = motion.aligned_or_none(motion.no_loss, shift)
        if without is not None and (_runs_apart(fine) or _explains_as_well(without, fine)):
            too_slow = _runs_apart(fine) or _explains_as_well(fine, without)
            lost, fine = motion.no_loss, without
    if _runs_apart(fine):
        fine = _with_clocks_that_run_alike(motion, lost, fine)
    fine = despite_late_forces(
        motion.signals,
        fine,
        lambda late, fine: replace(motion, signals=late).aligned(lost, fine.offset),
        lambda late, fine: refitted_to(motion.arm, late, fine, motion.fv),
    )
    _check_plausible(fine)
    if not too_slow:
        return lost, fine, []
    return lost, fine, [GAPS if motion.repaired.gaps else TOO_SLOW]


def _losses_by_window(motion: AlignedMotion) -> tuple[LostFrames, float]:
    """Losses, and a start of the offset, s, from cables fitted to the window that they fit best."""
    frames, period = motion.frames, motion.period
    cables = CableEquation(motion.signals, LINEAR)
    best: tuple[float, ClockSolution, int] | None = None
    for span in _lively_windows(motion):
        part = slice(*np.searchsorted(frames.time, span))
        if part.stop - part.start < MIN_FRAMES:
            continue
        window = replace(frames.part(part), middle=(span[0] + span[1]) / 2)
        start = shift_near(motion.video_speeds, motion.log_speeds, motion.coarse.shift, span, MAX_WINDOW_SHIFT_S)
        try:
            fit = fit_cables(ClockProblem(motion.signals, window, motion.fv), start, cables)
        except ClockUndetermined:
            continue
        error = float(np.sqrt(np.mean(fit.residual**2)))
        if best is None or error < best[0]:
            best = (error, fit, (part.start + part.stop) // 2)
    if best is None:
        return motion.no_loss, motion.coarse.shift
    _, fit, reference = best
    offset, winding = fit.unknowns.offset, fit.cables.expected_winding(fit.unknowns)
    whitening = _decoding_whitening(frames, WINDOW_CABLE_ERROR_M, period)
    skew = skew_despite_losses(frames, winding, offset, whitening, reference)
    count = decode_lost_frames(frames, winding, (offset, skew), whitening, period, reference)
    # losses count from the first frame on: there the offset is the reference's less what was lost before the reference
    return lost_frames_of(frames.time, count, period), offset + float(count[0]) * period


def _lively_windows(motion: AlignedMotion) -> list[tuple[float, float]]:
    """Windows of WINDOW_S within video, log and what was coarsely aligned, camera time, s, the liveliest first."""
    speeds, compared = motion.video_speeds, motion.coarse.span
    log_first, log_last = motion.signals.time[[0, -1]] - motion.coarse.shift
    first, last = max(motion.frames.time[0], log_first) + EDGE_S, min(motion.frames.time[-1], log_last) - EDGE_S
    begins = np.arange(first, last - WINDOW_S, WINDOW_S / 2)
    spans = [(float(t), float(t + WINDOW_S)) for t in begins]
    spans = [s for s in spans if s[0] >= compared[0] - 1 and s[1] <= compared[1] + 1] or spans
    return sorted(spans, key=lambda span: -float(np.sum(speeds.values[speeds.rows(span)] ** 2)))[:MAX_WINDOWS]


def _losses_by_whole(frames: FrameGeometry, fine: FineAlignment, lost: LostFrames) -> LostFrames:
    """Losses decoded with the cables and the geometry that the whole recording has given; `lost`: as it was fitted with."""
    unknowns, period = fine.fit.unknowns, lost.period
    true_time = lost.corrected(frames.time)
    reference = len(frames.time) // 2
    late = round((true_time[reference] - frames.time[reference]) / period) * period
    # the clock holds for true times; decoding needs it for stamps around the reference
    offset = unknowns.offset + late + unknowns.skew * (true_time[reference] - fine.frames.middle)
    count = decode_lost_frames(
        frames.with_geometry_errors(unknowns.geometry_errors),
        fine.fit.cables.expected_winding(unknowns),
        (offset, unknowns.skew),
        _decoding_whitening(frames, np.maximum(DECODING_CABLE_ERROR_M, 3 * unknowns.cable_error), period),
        period,
        reference,
    )
    return lost_frames_of(frames.time, count, period)


def _decoding_whitening(frames: FrameGeometry, cable_error: float | Array, period: float) -> Array:
    """Whitening (F, M, M) for frames one period, s, apart: frames that share one error of the cables weigh as one."""
    return frames.whitening(cable_error * max(1.0, 1 / (INDEPENDENT_ERRORS_HZ * period)) ** 0.5)


def _aligned_without_losses(motion: AlignedMotion) -> FineAlignment:
    """The clock where no frame is lost. Raises Refused where this is another arm, ClockUndetermined where the fit fails."""
    try:
        return motion.aligned(motion.no_loss, motion.coarse.shift)
    except ClockUndetermined:
        motion.check_alternative_arms(motion.no_loss, motion.coarse.shift)
        raise


def _with_clocks_that_run_alike(motion: AlignedMotion, lost: LostFrames, fine: FineAlignment) -> FineAlignment:
    """The clock with a skew that quartz has, where that explains as well; sigma holds what speaks for the other one.

    Cables that rub on their pulleys feign a skew, in a short recording a large one."""
    alike = motion.aligned_or_none(lost, fine.fit.unknowns.offset, QUARTZ_SCALE)
    if alike is None or _runs_apart(alike) or not _explains_as_well(alike, fine):
        return fine
    apart = alike.fit.unknowns.offset - fine.fit.unknowns.offset
    return replace(
        alike,
        offset_sigma=float(np.hypot(alike.offset_sigma, apart)),
        skew_sigma=float(np.hypot(alike.skew_sigma, SKEW_SIGMA)),
    )


def _runs_apart(fine: FineAlignment) -> bool:
    """Whether the clocks would run apart as none do."""
    return abs(fine.fit.unknowns.skew) > MAX_SKEW


def _explains_as_well(fine: FineAlignment, other: FineAlignment) -> bool:
    """Whether one clock's misfit is not clearly larger than another's."""
    return clock_misfit(fine.fit.unknowns) < MAX_MISFIT_RATIO * clock_misfit(other.fit.unknowns)


def _check_plausible(fine: FineAlignment) -> None:
    """Raises ClockUndetermined where no clock runs so fast, or no cables leave so much."""
    if _runs_apart(fine):
        ppm = 1e6 * abs(fine.fit.unknowns.skew)
        raise ClockUndetermined(
            "sync",
            f"cables and arm would have the clocks run apart by {ppm:.0f} ppm, which no clock does",
            "move faster and wider, or give both a light; are the stamps of frames and log true?",
        )
    residual = float(np.sqrt(np.mean(fine.fit.residual**2)))
    if residual > MAX_RESIDUAL_M:
        raise ClockUndetermined(
            "sync",
            f"{1e3 * residual:.1f} mm of the cables' lengths are left unexplained at best",
            "is neck.yaml of this arm, with its signs and routes, and are the stamps of frames and log true?",
        )
