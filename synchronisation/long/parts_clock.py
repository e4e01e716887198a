"""The clock of a long recording from the clocks of its parts: each part is aligned alone, and one clock goes through all.

What misleads the clock of one part misleads those of all: the offset is taken to be no better known than that of one part. Where
the parts' offsets scatter about the one clock by more than their sigmas, its sigmas are raised so.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import FrameLoss, LostFrames
from identification.dataset.series import Series
from identification.dataset.stretches import consecutive_spans
from mechanism.arm import Arm
from mechanism.description import Neck
from synchronisation.angles import Angles
from synchronisation.clocks.clock import fit_clock
from synchronisation.clocks.clock_estimate import ClockEstimate
from synchronisation.clocks.coarse_alignment import (
    SPEED_RATE_HZ,
    CableSpeeds,
    CoarseAlignment,
    align_stretched,
    cable_speeds,
    force_rates,
)
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.clocks.log_gaps import RepairedLog
from synchronisation.clocks.motion_clock import MIN_TRAVEL_M, check_repetition, stamped_period
from synchronisation.clocks.undetermined import ClockUndetermined
from synchronisation.log_plausibility import check_log_meaning
from synchronisation.long.recording_parts import angles_within, log_within
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

OVERLAP_S = 4.0
"""s by which parts reach beyond their spans: filters settle in it, and what happens at a seam is seen twice (docs/thresholds.md)"""
LOG_MARGIN_S = 3.0
"""s of the log beyond a part's frames on either side: by as much its clock may differ from its neighbour's (docs/thresholds.md)"""
UNEVEN_S = 1e-3
"""s, RMS, by which parts' clocks may scatter about one clock before a warning says so (docs/thresholds.md)"""


@dataclass(frozen=True)
class PartClock:
    """The clock of one part."""

    span: tuple[float, float]
    """camera times, s, for which it stands"""
    clock: ClockEstimate

    @property
    def losses(self) -> tuple[FrameLoss, ...]:
        """Losses within the span."""
        return tuple(loss for loss in self.clock.lost.losses if self.span[0] <= loss.time < self.span[1])


def clock_of_parts(
    neck: Neck, arm: Arm, angles: Angles, repaired: RepairedLog, fv: Array, progress: Callable[[int], object]
) -> ClockEstimate:
    """The clock of a recording that is aligned part by part; progress: called with the number of parts done since the last call.

    Raises Refused as `fit_clock` and `check_log_meaning` do, naming the part, and where the motion of no part determines a clock.
    """
    log, spans = repaired.log, consecutive_spans(float(angles.time[0]), float(angles.time[-1]))
    speeds = _video_speeds(arm, angles)
    anchor, coarse = _anchor(arm, speeds, log, spans)
    warnings = Counter[str](check_repetition(coarse))
    found: dict[int, PartClock] = {}
    undetermined: ClockUndetermined | None = None
    for way in (range(anchor, len(spans)), range(anchor - 1, -1, -1)):
        known = found.get(anchor)
        for k in way:
            middle = sum(spans[k]) / 2
            shift = coarse.shift if known is None else float(known.clock.log_time(np.array(middle))) - middle
            try:
                part, said = _part_clock(neck, arm, angles, log, fv, spans[k], shift)
                found[k] = known = part
                warnings.update(dict.fromkeys((*said, *part.clock.warnings), 1))
            except ClockUndetermined as refused:
                undetermined = refused
            progress(1)
    if not found:
        raise undetermined or ClockUndetermined("sync", "no part of the recording shows a motion", "record a motion")
    parts = [found[k] for k in sorted(found)]
    rests = len(spans) - len(parts)
    said = [text if n == 1 else f"{text} (in {n} of {len(parts)} parts)" for text, n in warnings.items()]
    said += [f"{rests} of {len(spans)} parts show too little motion for a clock of their own"] if rests else []
    return _through(parts, angles, coarse, repaired, tuple(said))


def _video_speeds(arm: Arm, angles: Angles) -> CableSpeeds:
    known = angles.ordinary
    if known.sum() < 2:
        raise Refused(
            "sync", f"only {known.sum()} frames have all angles", "check the overlay for what hides the markers"
        )
    return cable_speeds(angles.time[known], cable_winding(arm, angles.alpha[known]))


def _anchor(
    arm: Arm, video: CableSpeeds, log: Series, spans: Sequence[tuple[float, float]]
) -> tuple[int, CoarseAlignment]:
    """The liveliest part, and where it lies in the whole log."""
    # the log's speeds are wanted at SPEED_RATE_HZ: half of it is no loss to a linear interpolation
    stride = max(1, round(1 / (2 * SPEED_RATE_HZ * float(np.median(np.diff(log.time))))))
    thinned = log.part(slice(None, None, stride))
    of_log = cable_speeds(thinned.time, arm.drum * thinned.matrix("theta"))
    of_parts = [video.part(video.rows(span)) for span in spans]
    anchor = int(np.argmax([np.mean(part.values**2) for part in of_parts]))
    return anchor, align_stretched(of_parts[anchor], of_log, force_rates(thinned))[0]


def _part_clock(
    neck: Neck, arm: Arm, angles: Angles, log: Series, fv: Array, span: tuple[float, float], shift: float
) -> tuple[PartClock, tuple[str, ...]]:
    """The clock of one part, and warnings about its log; shift: about the log's time less the camera's, s."""
    first, last = span[0] - OVERLAP_S, span[1] + OVERLAP_S
    seen = angles_within(angles, first, last)
    logged = log_within(log, first + shift - LOG_MARGIN_S, last + shift + LOG_MARGIN_S)
    winding = cable_winding(arm, seen.alpha[seen.complete])
    if len(winding) < 2 or len(logged) < 2 or np.ptp(winding, axis=0).max() < MIN_TRAVEL_M:
        raise ClockUndetermined("sync", f"the arm rests from {span[0]:.0f} to {span[1]:.0f} s of the video")
    try:
        warnings = check_log_meaning(neck, arm, seen, logged)
        return PartClock(span, fit_clock(arm, seen, logged, fv)), warnings
    except ClockUndetermined:
        raise
    except Refused as refused:
        where = f"{refused.where}, {span[0]:.0f} to {span[1]:.0f} s of the video"
        raise Refused(where, refused.what, refused.do) from refused


def _through(
    parts: Sequence[PartClock],
    angles: Angles,
    coarse: CoarseAlignment,
    repaired: RepairedLog,
    warnings: tuple[str, ...],
) -> ClockEstimate:
    """One clock through those of the parts, with frames that were lost within parts and between them."""
    source = Counter(part.clock.source for part in parts).most_common(1)[0][0]
    if without := sum(part.clock.source != source for part in parts):
        warnings = (*warnings, f"{without} of {len(parts)} parts have no clock from {source}, and count for nothing")
    parts = [part for part in parts if part.clock.source == source]
    lost = _losses(parts, stamped_period(angles))
    stamps = np.array([sum(part.span) / 2 for part in parts])
    true = lost.corrected(stamps)
    offsets = np.array([float(p.clock.log_time(np.array(t))) for p, t in zip(parts, stamps, strict=True)]) - true
    sigma = np.array([part.clock.offset_sigma for part in parts])
    middle = float((lost.corrected(angles.time[0]) + lost.corrected(angles.time[-1])) / 2)
    A = np.stack([np.ones(len(parts)), true - middle], axis=1) / sigma[:, None]
    if len(parts) == 1:  # its own skew is all that is known
        A = np.vstack([A, [0.0, 1 / parts[0].clock.skew_sigma]])
        b = np.array([offsets[0] / sigma[0], parts[0].clock.skew / parts[0].clock.skew_sigma])
    else:
        b = offsets / sigma
    covariance = np.linalg.inv(A.T @ A)
    offset, skew = (covariance @ (A.T @ b)).tolist()
    scatter = A @ np.array([offset, skew]) - b
    raised = max(1.0, float(scatter @ scatter) / max(len(b) - 2, 1))
    uneven = float(np.sqrt(np.mean((scatter[: len(sigma)] * sigma) ** 2)))
    if uneven > UNEVEN_S:
        warnings = (
            *warnings,
            f"the clocks of camera and log do not run evenly: parts are {1e3 * uneven:.1f} ms off one clock, RMS",
        )
    offset_sigma, skew_sigma = np.sqrt(raised * np.diag(covariance)).tolist()
    first = parts[0].clock
    delays = np.array([part.clock.delay for part in parts if part.clock.delay is not None])
    return replace(
        first,
        offset=offset,
        offset_sigma=float(np.hypot(max(offset_sigma, float(np.median(sigma))), uneven if uneven > UNEVEN_S else 0.0)),
        skew=skew,
        skew_sigma=skew_sigma,
        middle=middle,
        correlation=coarse.correlation,
        second_peak=coarse.second_peak,
        residual_rms=np.sqrt(np.mean([part.clock.residual_rms**2 for part in parts], axis=0)),
        source=source,
        lost=lost,
        repaired=repaired,
        warnings=warnings,
        delay=(float(np.median(delays[:, 0])), float(np.median(delays[:, 1]))) if len(delays) else None,
        light=first.light
        and replace(first.light, switches=sum(part.clock.light.switches for part in parts if part.clock.light)),
        motion_offset=None,
    )


def _losses(parts: Sequence[PartClock], period: float) -> LostFrames:
    """Frames that were lost within parts; and where one ends and the next begins, by how far their clocks are apart there."""
    losses = list(parts[0].losses)
    for before, after in pairwise(parts):
        seam = np.array(after.span[0])
        frames = round(float(after.clock.log_time(seam) - before.clock.log_time(seam)) / period)
        losses += [FrameLoss(after.span[0], frames)] if frames else []
        losses += after.losses
    return LostFrames(tuple(losses), period)
