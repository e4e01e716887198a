"""The clock from the motion that log and video both show.

Coarse alignment by cross-correlation, a check of signs and labels, then a fit to what cables and arm do, with frames that were
lost; without forces in the log, a rougher fit to the cables alone.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import LostFrames
from identification.dataset.series import Series
from mechanism.arm import Arm
from synchronisation.angles import Angles
from synchronisation.clocks.clock_estimate import ClockEstimate
from synchronisation.clocks.coarse_alignment import (
    MAX_SECOND_PEAK,
    MIN_OVERLAP_S,
    SECOND_PEAK_WARNING,
    CoarseAlignment,
    align_stretched,
    cable_speeds,
    force_rates,
)
from synchronisation.clocks.exchanged_labels import check_labels
from synchronisation.clocks.frame_geometry import cable_winding, frame_geometry
from synchronisation.clocks.log_gaps import RepairedLog
from synchronisation.clocks.lost_frame_alignment import AlignedMotion
from synchronisation.clocks.signals import log_signals_of
from synchronisation.clocks.slip_alignment import align_despite_slips
from synchronisation.clocks.undetermined import ClockUndetermined
from synchronisation.clocks.usable_frames import MIN_FRAMES, usable_frames
from synchronisation.clocks.winch_slips import signals_without_slips
from synchronisation.clocks.without_force import fit_rigid_cables
from synchronisation.encoder_log import uniformly_sampled
from synchronisation.frame_noise import noise_correlation
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MIN_TRAVEL_M = 1e-3
"""m: some cable must move by this in the video, and some motor in the log (docs/thresholds.md)"""

UNEXPLAINED_M = 5e-4
"""m, RMS: a cable that forces leave so much of may have another force than the log says (docs/thresholds.md)"""
UNEXPLAINED_SHARE = 0.4
"""... and has, if they leave this share of what a rigid cable leaves (docs/thresholds.md)"""
WITHOUT_FORCES = "the log holds no forces, so how far cables stretch is unknown: the clock is good to milliseconds only"


def clock_from_motion(arm: Arm, angles: Angles, repaired: RepairedLog, fv: Array | None) -> ClockEstimate:
    """The clock from angles and log; fv: (M,), N s/rad, NaN where not known.

    Raises ClockUndetermined where the motion does not determine it, Refused where what was recorded contradicts itself."""
    known = angles.ordinary
    time, alpha, sigma = angles.time[known], angles.alpha[known], angles.sigma[known]
    if len(time) < MIN_FRAMES:
        raise Refused(
            "sync", f"only {len(time)} frames have all angles", "check the overlay for what hides the markers"
        )
    log = uniformly_sampled(repaired.log)
    winding, travel = cable_winding(arm, alpha), arm.drum * log.matrix("theta")
    _check_motion(time, winding, log.time, travel)
    video_speeds, log_speeds = cable_speeds(time, winding), cable_speeds(log.time, travel, repaired.gaps)
    coarse, unstretched = align_stretched(video_speeds, log_speeds, force_rates(log, repaired.gaps))
    # exchanges are sought in the log as it is: what is exchanged tells no stretch
    check_labels(arm, time, alpha, video_speeds, log_speeds, coarse)
    repetition = check_repetition(coarse)
    signals = log_signals_of(arm, log)
    motion = AlignedMotion(
        arm=arm,
        signals=signals,
        repaired=repaired,
        frames=frame_geometry(
            arm, time, alpha, sigma, (time[0] + time[-1]) / 2, noise_correlation(time, alpha, angles.white_sigma[known])
        ),
        period=stamped_period(angles),
        fv=np.full(arm.M, np.nan) if fv is None else fv,
        video_speeds=video_speeds,
        log_speeds=unstretched,
        coarse=coarse,
    )
    if signals.has_force:
        clock = _from_cables_and_arm(motion, log)
        misled = clock.residual_rms > UNEXPLAINED_M
        if misled.any():
            clock = _despite_misleading_forces(clock, misled, motion, log)
    else:
        clock = _from_rigid_cables(motion, log)
        clock = replace(clock, warnings=(*clock.warnings, WITHOUT_FORCES))
    return replace(clock, warnings=(*repetition, *clock.warnings))


def stamped_period(angles: Angles) -> float:
    """The camera's period by the stamps, s: the mean of the steps that are of one period.

    Every lost frame is taken for one period, so that an error of the period grows with their number; stamps jitter, and a median
    of their steps errs by much more than the mean."""
    steps = np.diff(angles.time)
    return float(np.mean(steps[np.rint(steps / np.median(steps)) == 1]))


def _too_short(time: Array, log_time: Array) -> tuple[str, str]:
    """Which of frames' and rows' times, s, end before MIN_OVERLAP_S have passed, and what to do."""
    name, short = min(("video", time), ("log", log_time), key=lambda named: named[1][-1] - named[1][0])
    seconds = short[-1] - short[0]
    what = f"the {name} is {seconds:.3g} s long, at {len(short) / seconds:.3g} times a second; {MIN_OVERLAP_S:.0f} s are needed"
    in_minutes = bool(60 * seconds >= MIN_OVERLAP_S)
    return what, "record longer" + ", or write seconds, if its time is in minutes" * in_minutes


def _check_motion(time: Array, winding: Array, log_time: Array, travel: Array) -> None:
    """Refused where video or log is too short, or shows no motion."""
    if min(time[-1] - time[0], log_time[-1] - log_time[0]) < MIN_OVERLAP_S:
        raise ClockUndetermined("sync", *_too_short(time, log_time))
    moved = np.ptp(winding, axis=0).max()
    if moved < MIN_TRAVEL_M:
        raise ClockUndetermined(
            "sync", f"the cables move by {1e3 * moved:.2f} mm only", "record a motion of at least 10 deg"
        )
    if np.ptp(travel, axis=0).max() < MIN_TRAVEL_M:
        raise Refused("sync", "the motors of the log stand still", "is it the log of this recording?")


def check_repetition(coarse: CoarseAlignment) -> tuple[str, ...]:
    """Refused where the motion repeats itself, a warning where it nearly does."""
    percent = 100 * coarse.second_peak
    if coarse.second_peak > MAX_SECOND_PEAK:
        raise ClockUndetermined(
            "sync",
            f"the motion repeats itself: another shift fits {percent:.0f} % as well",
            "record a motion that is not periodic",
        )
    if coarse.second_peak > SECOND_PEAK_WARNING:
        return (f"another shift fits {percent:.0f} % as well: the motion nearly repeats itself",)
    return ()


def _from_cables_and_arm(motion: AlignedMotion, log: Series) -> ClockEstimate:
    """The clock where the log holds forces; log: of equal steps."""
    explanation = align_despite_slips(motion, log)
    fine = explanation.fine
    unknowns = fine.fit.unknowns
    return ClockEstimate(
        offset=unknowns.offset,
        offset_sigma=fine.offset_sigma,
        skew=unknowns.skew,
        skew_sigma=fine.skew_sigma,
        middle=fine.frames.middle,
        correlation=motion.coarse.correlation,
        second_peak=motion.coarse.second_peak,
        residual_rms=fine.fit.residual_rms,
        source="cables and arm",
        lost=explanation.lost,
        repaired=motion.repaired,
        warnings=explanation.warnings,
        delay=(fine.delay, fine.delay_sigma),
    )


def _despite_misleading_forces(
    clock: ClockEstimate, misled: NDArray[np.bool_], motion: AlignedMotion, log: Series
) -> ClockEstimate:
    """The clock of rigid cables where the logged force of one of `misled` (M,) explains hardly more than none would.

    A wrong force bends the laws of all cables through the arm's equation, by much more than elongation is worth."""
    rigid = _from_rigid_cables(motion, log)
    misled = misled & (clock.residual_rms > UNEXPLAINED_SHARE * rigid.residual_rms)
    if not misled.any():
        return clock
    cable = int(np.argmax(np.where(misled, clock.residual_rms, 0.0)))
    warning = (
        f"f{cable + 1} does not explain how far cable {cable + 1} stretches ({1e3 * clock.residual_rms[cable]:.1f} mm are left), "
        "so the clock is that of rigid cables, good to milliseconds only"
    )
    return replace(rigid, warnings=(*rigid.warnings, warning))


def _from_rigid_cables(motion: AlignedMotion, log: Series) -> ClockEstimate:
    """The clock where the log holds no forces; lost frames are not sought. log: of equal steps."""
    lost, shift = LostFrames(period=motion.period), motion.coarse.shift
    signals, slips = signals_without_slips(motion.arm, log, motion.frames.time + shift, motion.frames.winding)
    clear = replace(motion.repaired, gaps=(*motion.repaired.gaps, *(slip.trace for slip in slips)))
    frames = usable_frames(motion.frames, signals, clear, lost, shift)
    fit = fit_rigid_cables(signals, frames, shift)
    return ClockEstimate(
        offset=fit.offset,
        offset_sigma=fit.offset_sigma,
        skew=fit.skew,
        skew_sigma=fit.skew_sigma,
        middle=frames.middle,
        correlation=motion.coarse.correlation,
        second_peak=motion.coarse.second_peak,
        residual_rms=np.sqrt(np.mean(fit.residual**2, axis=0)),
        source="cables without forces",
        lost=lost,
        repaired=motion.repaired,
        warnings=tuple(slip.warning(signals.has_force) for slip in slips),
    )
