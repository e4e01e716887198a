"""One clock: log time = camera time + offset + skew (camera time - its middle).

Camera time is a frame's stamp, put right where frames were lost without a trace. The motion is found in the log roughly,
signs and labels are settled, and then offset and skew are fitted to what cables and arm do; a light that the controller
switched replaces that last step.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from mechanism.arm import Arm
from synchronisation.angles import Angles
from synchronisation.clocks.cables import Frames, frames_of, part_of, whitening, wound
from synchronisation.clocks.coarse import MIN_OVERLAP, RATE, Match, Speeds, match, nearby, speeds
from synchronisation.clocks.fine import AS_WELL, LADDER, Fine, fit_cables, fit_fine, unexplained
from synchronisation.clocks.labels import check_alternatives, check_labels
from synchronisation.clocks.light import Anchor, edges_of, fit_anchor
from synchronisation.clocks.log_gaps import Mended, mend
from synchronisation.clocks.lost_frames import Slips, decode, locked_skew, slips_of
from synchronisation.clocks.newton_step import LIKELY_SKEW
from synchronisation.clocks.rope_steps import steady_signals
from synchronisation.clocks.signals import LogSignals
from synchronisation.clocks.undetermined import NoClue
from synchronisation.clocks.without_force import fit_without_force
from synchronisation.encoder_log import uniform
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

EDGE = 0.75
"""s left out at both ends, where filters settle"""
BESIDE = 0.1
"""s left out beside gaps of the log"""
LEAST_TRAVEL = 1e-3
"""m"""
LEAST_FRAMES = 30
PERIODIC, NEARLY_PERIODIC = 0.9, 0.85
"""a second peak of the correlation this high is refused, and flagged"""
UNLIKELY = 4.0
"""times what clocks run apart likely: a fit that comes to more has not found the motion"""
DISAGREES = 4.0
"""sigma between light and motion that are reported"""
REFERENCE, REFERENCES = 4.0, 10
"""s of a window in which cables are first fitted, short enough to be without losses, and how many are tried"""
LARGEST_M = 2e-3
"""m, RMS, that no arm's cables leave: elongations in all are of this size"""
ASTRAY = 2.0
"""s by which lost frames may have moved a window from the first match"""
FIRST_DECODING, DECODING = 3e-4, 5e-5
"""m: how well cables are known while lost frames are sought, from one window and from the whole recording"""

TOO_SLOW = "the motion is too slow to tell whether frames were lost"


@dataclass(frozen=True)
class Clock:
    """Camera to log: offset in s at the middle of the camera's time, skew as a ratio, with their sigmas."""

    offset: float
    offset_sigma: float
    skew: float
    skew_sigma: float
    middle: float
    """camera time at which the offset holds, s"""
    likeness: float
    """correlation of predicted and logged cable speeds at the coarse match"""
    second: float
    """the next best match's correlation over the best one's"""
    residual: Array
    """RMS of the fit of each cable, (M,), m"""
    source: str
    """what the clock rests on: `cables and arm`, `cables without forces`, `light`"""
    slips: Slips
    """frames lost without a trace, and the frames' period"""
    log: Mended
    """the log without repeated rows, and its gaps"""
    warnings: tuple[str, ...]
    delay: tuple[float, float] | None = None
    """by how much forces act later than the log says, and its sigma, s; None where no motion told"""
    anchor: Anchor | None = None
    mechanics: tuple[float, float] | None = None
    """where a light is the source: what cables and arm would have said, offset and its sigma, s"""

    def log_time(self, camera_time: Array) -> Array:
        """Stamps of frames on the log's clock, s."""
        true = self.slips.corrected(camera_time)
        return true + self.offset + self.skew * (true - self.middle)


def fit_clock(arm: Arm, angles: Angles, log: Series, fv: Array | None = None) -> Clock:
    """Offset and skew from angles (camera clock) and a log as recorded; fv (M,), N s/rad, NaN where not known.

    With a light in both, `led` in the log and `angles.light`, the clock is the light's alone: cables and arm then only settle
    labels and lost frames, and what they would have said is kept beside it.

    Raises Refused where the two do not show the same motion, show too little of it, repeat so that a period could be mistaken,
    overlap too little, or where cables, angles or signs are exchanged.
    """
    mended = mend(log)
    by_light = "led" in log.columns and angles.light is not None
    try:
        clock = _by_motion(arm, angles, mended, fv)
    except NoClue:
        if not by_light:
            raise
        period = float(np.median(np.diff(angles.time)))
        clock = Clock(0.0, np.inf, 0.0, np.inf, 0.0, 0.0, 0.0, np.zeros(arm.M), "", Slips(period=period), mended, ())
    return _by_light(clock, angles, log) if by_light else clock


def _by_light(clock: Clock, angles: Angles, log: Series) -> Clock:
    """The same clock, tied by the light."""
    assert angles.light is not None
    seen = angles.notes.get("light", {})
    true = clock.slips.corrected(angles.time) + seen.get("later_s", 0.0)
    anchor = fit_anchor(*edges_of(log.time, log.columns["led"]), true, angles.light, seen.get("exposure_s", 0.0))
    mechanics, warnings = None, clock.warnings
    if np.isfinite(clock.offset_sigma):
        mechanics = (clock.offset + clock.skew * (anchor.middle - clock.middle), clock.offset_sigma)
        apart = mechanics[0] - anchor.offset
        if abs(apart) > DISAGREES * np.hypot(clock.offset_sigma, anchor.offset_sigma):
            warnings = (*warnings, f"cables and arm put the clock {1e3 * apart:+.2f} ms away from the light")
    return replace(
        clock,
        offset=anchor.offset,
        offset_sigma=anchor.offset_sigma,
        skew=anchor.skew,
        skew_sigma=anchor.skew_sigma,
        middle=anchor.middle,
        source="light",
        warnings=warnings,
        anchor=anchor,
        mechanics=mechanics,
    )


def _by_motion(arm: Arm, angles: Angles, mended: Mended, fv: Array | None) -> Clock:
    """The clock from the motion. Raises NoClue where it tells none, Refused where what was recorded contradicts itself."""
    good = angles.complete
    time, alpha, sigma = angles.time[good], angles.alpha[good], angles.sigma[good]
    if len(time) < LEAST_FRAMES:
        raise Refused(
            "sync", f"only {len(time)} frames have all angles", "check the overlay for what hides the markers"
        )
    even = uniform(mended.log)
    winding = wound(arm, alpha)
    travel = arm.drum * even.matrix("theta")
    _check_motion(time, winding, even.time, travel)
    seen, logged = speeds(time, winding), speeds(even.time, travel)
    found = match(seen, logged)
    check_labels(arm, time, alpha, seen, logged, found)
    if found.second > PERIODIC:
        raise NoClue(
            "sync",
            f"the motion repeats itself: another shift fits {100 * found.second:.0f} % as well",
            "record a motion that is not periodic",
        )
    warnings = []
    if found.second > NEARLY_PERIODIC:
        warnings.append(f"another shift fits {100 * found.second:.0f} % as well: the motion nearly repeats itself")
    signals, steps = steady_signals(arm, even, time + found.shift, winding)
    warnings += [step.words() for step in steps]
    held = replace(mended, gaps=(*mended.gaps, *(step.trace for step in steps)))
    viscosity = np.full(arm.M, np.nan) if fv is None else fv
    every = frames_of(arm, time, alpha, sigma, (time[0] + time[-1]) / 2)
    slips = Slips(period=float(np.median(np.diff(angles.time))))
    if signals.has_force:
        both = _Both(arm, signals, held, every, slips.period, viscosity)
        slips, fine, more = _by_cables_and_arm(both, seen, logged, found)
        warnings += more
        delay = (fine.fit.state.delay, fine.delay_sigma)
        state, frames, residual, source = fine.fit.state, fine.frames, fine.fit.residual, "cables and arm"
        offset, offset_sigma, skew, skew_sigma = state.offset, fine.offset_sigma, state.skew, fine.skew_sigma
    else:
        delay, frames = None, _compared(every, signals, held, slips, found.shift)
        offset, offset_sigma, skew, skew_sigma, residual = fit_without_force(signals, frames, found.shift)
        source = "cables without forces"
        warnings.append(
            "the log holds no forces, so how far cables stretch is unknown: the clock is good to milliseconds only"
        )
    return Clock(
        offset,
        offset_sigma,
        skew,
        skew_sigma,
        frames.middle,
        found.likeness,
        found.second,
        np.sqrt(np.mean(residual**2, axis=0)),
        source,
        slips,
        mended,
        tuple(warnings),
        delay,
    )


@dataclass(frozen=True)
class _Both:
    """Frames and log of one motion."""

    arm: Arm
    signals: LogSignals
    mended: Mended
    every: Frames
    """by their stamps"""
    period: float
    fv: Array

    def fitted(self, slips: Slips, start: float) -> Fine:
        """The clock with these frames lost, from an offset on."""
        return fit_fine(self.arm, self.signals, self.compared(slips, start), start, self.fv)

    def attempted(self, slips: Slips, start: float) -> Fine | None:
        """The same, None where the fit goes astray."""
        try:
            return self.fitted(slips, start)
        except NoClue:
            return None

    def compared(self, slips: Slips, start: float) -> Frames:
        """Frames within the log with these lost."""
        return _compared(self.every, self.signals, self.mended, slips, start)

    def check_alternatives(self, slips: Slips, *offsets: float) -> None:
        """Refused where the cables of another arm fit better, from any of the offsets."""
        check_alternatives(self.arm, self.signals, self.compared(slips, offsets[0]), offsets, LADDER[0].law, self.fv)


def _by_cables_and_arm(both: _Both, seen: Speeds, logged: Speeds, found: Match) -> tuple[Slips, Fine, list[str]]:
    """Frames lost without a trace, the clock with them, and warnings."""
    slips, start = _first_slips(both, seen, logged, found)
    none, warnings = Slips(period=both.period), list[str]()
    fine = both.attempted(slips, start)
    if fine is None:
        slips, fine = none, _without_slips(both, none, found.shift)
        warnings.append(TOO_SLOW)
    both.check_alternatives(slips, fine.fit.state.offset, found.shift)
    if not warnings:
        again = _slips_again(both.every, fine, slips)
        better = both.attempted(again, fine.fit.state.offset) if again != slips else None
        slips, fine = (slips, fine) if better is None else (again, better)
    if slips.slips and abs(fine.fit.state.skew) > LIKELY_SKEW:
        # slow motion tells lost frames badly: what was taken for some may be none, and runs the clocks apart
        whole = both.attempted(none, found.shift)
        if whole and (_apart(fine) or unexplained(whole.fit.state) < AS_WELL * unexplained(fine.fit.state)):
            slips, fine = none, whole
            warnings.append(TOO_SLOW)
    if _apart(fine):
        ppm = 1e6 * abs(fine.fit.state.skew)
        apart = f"cables and arm would have the clocks run apart by {ppm:.0f} ppm, which no clock does"
        raise NoClue("sync", apart, "move faster and wider, or give both a light")
    left = float(np.sqrt(np.mean(fine.fit.residual**2)))
    if left > LARGEST_M:
        word = f"{1e3 * left:.1f} mm of the cables' lengths are left unexplained at best"
        raise NoClue("sync", word, "is neck.yaml of this arm, with its signs and routes?")
    return slips, fine, warnings


def _without_slips(both: _Both, none: Slips, offset: float) -> Fine:
    """The clock where no frame is lost. Raises Refused where this is another arm, NoClue where it is not told either."""
    try:
        return both.fitted(none, offset)
    except NoClue:
        both.check_alternatives(none, offset)
        raise


def _apart(fine: Fine) -> bool:
    """Whether clocks would run apart as none do."""
    return abs(fine.fit.state.skew) > UNLIKELY * LIKELY_SKEW


def _check_motion(time: Array, winding: Array, log_time: Array, travel: Array) -> None:
    if min(time[-1] - time[0], log_time[-1] - log_time[0]) < MIN_OVERLAP:
        raise NoClue("sync", f"video or log is shorter than {MIN_OVERLAP:.0f} s", "record longer")
    moved = np.ptp(winding, axis=0).max()
    if moved < LEAST_TRAVEL:
        raise NoClue("sync", f"the cables move by {1e3 * moved:.2f} mm only", "record a motion of at least 10 deg")
    if np.ptp(travel, axis=0).max() < LEAST_TRAVEL:
        raise Refused("sync", "the motors of the log stand still", "is it the log of this recording?")


def _compared(every: Frames, signals: LogSignals, mended: Mended, slips: Slips, offset: float) -> Frames:
    """Frames at their true times that lie within the log and clear of its gaps; their middle is where the offset holds."""
    true = slips.corrected(every.time)
    at = true + offset
    inside = (at > signals.time[0] + EDGE) & (at < signals.time[-1] - EDGE)
    inside &= (true > true[0] + EDGE) & (true < true[-1] - EDGE) & mended.outside(at, BESIDE)
    if inside.sum() < LEAST_FRAMES or np.ptp(true[inside]) < MIN_OVERLAP - 2 * EDGE:
        overlap = float(np.ptp(true[inside])) if inside.any() else 0.0
        raise NoClue(
            "sync", f"log and video overlap by {overlap:.1f} s", f"record at least {MIN_OVERLAP:.0f} s of both"
        )
    kept = replace(every, time=true, middle=float(true[inside][0] + true[inside][-1]) / 2)
    return part_of(kept, inside)


def _first_slips(both: _Both, seen: Speeds, logged: Speeds, found: Match) -> tuple[Slips, float]:
    """Frames lost without a trace, and a start for the offset, from cables fitted to the window that they fit best."""
    every, signals, period = both.every, both.signals, both.period
    first, last = signals.time[[0, -1]] - found.shift
    edges = np.arange(max(every.time[0], first) + EDGE, min(every.time[-1], last) - EDGE - REFERENCE, REFERENCE / 2)
    spans = [(float(t), float(t + REFERENCE)) for t in edges]
    spans = [s for s in spans if s[0] >= found.span[0] - 1 and s[1] <= found.span[1] + 1] or spans
    lively = sorted(spans, key=lambda s: -_activity(seen, s))[:REFERENCES]
    best = None
    for span in lively:
        kept = slice(*np.searchsorted(every.time, span))
        if kept.stop - kept.start < LEAST_FRAMES:
            continue
        window = replace(part_of(every, kept), middle=(span[0] + span[1]) / 2)
        start = nearby(seen, logged, found.shift, span, ASTRAY)
        try:
            fit, cables = fit_cables(both.arm, signals, window, start, both.fv)
        except NoClue:
            continue
        error = float(np.sqrt(np.mean(fit.residual**2)))
        if best is None or error < best[0]:
            best = (error, fit, cables, (kept.start + kept.stop) // 2)
    if best is None:
        return Slips(period=period), found.shift
    _, fit, cables, at = best
    curve = cables.without_elongation(fit.state)
    whiten = whitening(every, FIRST_DECODING)
    skew = locked_skew(every, curve, fit.state.offset, whiten, at)
    count = decode(every, curve, fit.state.offset, skew, whiten, period, at)
    # counts go from the first frame on, so the offset there is that of the reference less what was lost before it
    return slips_of(every.time, count, period), fit.state.offset + float(count[0]) * period


def _slips_again(every: Frames, fine: Fine, slips: Slips) -> Slips:
    """The same with the cables as the whole recording has shown them."""
    state = fine.fit.state
    curve = fine.cables.without_elongation(state)
    true = slips.corrected(every.time)
    at = len(every.time) // 2
    whiten = whitening(every, max(DECODING, 3 * state.model_error))
    late = round((true[at] - every.time[at]) / slips.period) * slips.period
    # the clock holds for true times; here it is asked for stamps around frame `at`
    middle = fine.frames.middle
    offset = state.offset + late + state.skew * (true[at] - middle)
    count = decode(every.with_dimensions(state.dimensions), curve, offset, state.skew, whiten, slips.period, at)
    return slips_of(every.time, count, slips.period)


def _activity(seen: Speeds, span: tuple[float, float]) -> float:
    part = slice(*(max(0, int((t - seen.first) * RATE)) for t in span))
    return float(np.sum(seen.values[part] ** 2))
