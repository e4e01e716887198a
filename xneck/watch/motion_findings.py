"""What video and log say of one motion: signs and units, exchanged labels, a motion that repeats itself, and lost frames.

All is judged over the newest seconds by the checks of `sync`, which judge a whole recording."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from mechanism.arm import Arm
from mechanism.description import Neck
from synchronisation.angles import Angles
from synchronisation.clocks.coarse_alignment import (
    MAX_SECOND_PEAK,
    MIN_PEAK_SEPARATION_S,
    SPEED_RATE_HZ,
    CableSpeeds,
    align_stretched,
    cable_speeds,
    force_rates,
)
from synchronisation.clocks.exchanged_labels import MIN_CORRELATION, check_labels
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.clocks.motion_clock import MIN_TRAVEL_M
from synchronisation.encoder_log import uniformly_sampled
from synchronisation.log_plausibility import check_log_meaning
from xneck.watch.finding import Finding
from xneck.watch.log_findings import refused_finding
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MIN_WINDOW_TRAVEL_M = 3e-3
"""m that some cable must wind within the window, before log and video are compared (docs/thresholds.md)"""
REPETITION_S = 6.0
"""s over which a motion is compared with itself (docs/thresholds.md)"""
SAME_LIKENESS = 0.03
"""difference of likeness within which the shorter of two periods is the period"""
SMALL_MOTION_S = 8.0
"""s after which a recording in which no cable has wound by MIN_TRAVEL_M is said to show no motion (docs/thresholds.md)"""
MIN_SHIFT_PERIODS, MIN_SHIFT_S = 0.6, 0.015
"""frame periods, and s, by which log and video must move apart before frames are said to be lost: the shift of a window errs by
4 ms (docs/thresholds.md)"""
SHIFT_CORRELATION = 0.9
"""correlation from which on a window's shift is believed (docs/thresholds.md)"""


@dataclass(frozen=True)
class Window:
    """The newest frames with all angles, and the part of the log in which they must be found."""

    angles: Angles
    log: Series


@dataclass(frozen=True)
class Shift:
    """Log time less camera time, s, as the window that ends at a time, s, shows it."""

    time: float
    shift: float


def motion_findings(neck: Neck, arm: Arm, window: Window) -> tuple[list[Finding], Shift | None]:
    """Whether log and video of a window can be of one motion of this arm, and their shift where they are."""
    angles, log = window.angles, uniformly_sampled(window.log)
    winding, travel = cable_winding(arm, angles.alpha), arm.drum * log.matrix("theta")
    if np.ptp(winding, axis=0).max() < MIN_WINDOW_TRAVEL_M:
        return [], None
    if np.ptp(travel, axis=0).max() < MIN_TRAVEL_M:
        what = "the motors of the log stand still while the arm moves"
        return [Finding("signs_or_units", log.time[0], "log", what, "is it the log of this recording?")], None
    video, motors = cable_speeds(angles.time, winding), cable_speeds(log.time, travel)
    alignment, _ = align_stretched(video, motors, force_rates(log))
    # what is seen here may have begun with the window
    onset = float(angles.time[0]) + alignment.shift if alignment.correlation > MIN_CORRELATION else float(log.time[0])
    findings = []
    try:
        check_log_meaning(neck, arm, angles, window.log)
    except Refused as refusal:
        findings.append(refused_finding("signs_or_units", refusal, onset))
    try:
        check_labels(arm, angles.time, angles.alpha, video, motors, alignment)
    except Refused as refusal:
        findings.append(refused_finding("signs_or_labels", refusal, onset))
    believed = not findings and alignment.correlation > SHIFT_CORRELATION
    return findings, Shift(float(angles.time[-1]), alignment.shift) if believed else None


def repetition_finding(arm: Arm, angles: Angles) -> Finding | None:
    """Whether the newest REPETITION_S of a motion repeat themselves, so that they tell no clock."""
    part = angles.time >= angles.time[-1] - REPETITION_S
    time, winding = angles.time[part], cable_winding(arm, angles.alpha[part])
    if len(time) < 2 or time[-1] - time[0] < 0.9 * REPETITION_S or np.ptp(winding, axis=0).max() < MIN_WINDOW_TRAVEL_M:
        return None
    period, likeness = _repetition(cable_speeds(time, winding))
    if likeness < MAX_SECOND_PEAK:
        return None
    return Finding(
        kind="periodic_motion",
        onset_s=float(time[0]),
        clock="camera",
        what=f"the motion repeats itself every {period:.2f} s (it is {100 * likeness:.0f} % alike): it tells no clock",
        do="play a motion that is not periodic, such as one of `xneck design`",
    )


def small_motion_finding(arm: Arm, angles: Angles, first_s: float, largest_m: float) -> Finding | None:
    """Whether a recording that began at `first_s`, s, has shown no motion yet; largest_m: m, that any cable has wound so far."""
    if angles.time[-1] - first_s < SMALL_MOTION_S or largest_m >= MIN_TRAVEL_M:
        return None
    what = f"no cable has wound by more than {1e3 * largest_m:.2f} mm so far: the clock cannot be told"
    return Finding("small_motion", first_s, "camera", what, "record a motion of at least 10 deg")


def untraced_loss(shifts: Sequence[Shift], window_s: float, period: float) -> Finding | None:
    """Whether log and video have moved apart since the windows before the newest: frames were lost that stamps do not show."""
    newest = shifts[-1]
    before = [s.shift for s in shifts if s.time <= newest.time - window_s]
    if not before:
        return None
    step = newest.shift - float(np.median(before))
    if abs(step) < max(MIN_SHIFT_PERIODS * period, MIN_SHIFT_S):
        return None
    onset = newest.time - window_s
    reason = "frames were lost without a trace" if step > 0 else "the log lost rows, or a clock jumped"
    what = f"video and log have moved apart by {1e3 * step:+.0f} ms or more since {onset:.1f} s: {reason}"
    return Finding(
        "lost_frames_untraced", onset, "camera", what, "does the program that records keep up?", f"{onset:.0f}"
    )


def _repetition(speeds: CableSpeeds) -> tuple[float, float]:
    """The lag, s, at which speeds are most like themselves, at most half of them away, and how much: 1 for a periodic motion."""
    a = speeds.values
    lags = np.arange(1, len(a) // 2)
    alike = np.array(
        [np.sum(a[:-k] * a[k:]) / np.sqrt(max(np.sum(a[:-k] ** 2) * np.sum(a[k:] ** 2), 1e-300)) for k in lags]
    )
    inner = alike[1:-1]
    peaks = np.flatnonzero((inner > alike[:-2]) & (inner >= alike[2:])) + 1
    peaks = peaks[lags[peaks] > MIN_PEAK_SEPARATION_S * SPEED_RATE_HZ]
    if not len(peaks):
        return 0.0, 0.0
    # multiples of a period are as much alike as the period
    best = int(peaks[np.argmax(alike[peaks] > alike[peaks].max() - SAME_LIKENESS)])
    return float(lags[best]) / SPEED_RATE_HZ, float(alike[best])
