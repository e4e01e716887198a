"""The clock together with winch slips, told from frames that were lost.

Frames lost without a trace put all cables off at once, in proportion to their speeds; a slip puts one cable off, by a length that
stays. To the search for slips the one may look like the other, and so it does to the decoding of losses. Therefore the recording
is fitted without slips, with those that are seen at the coarse alignment, and with those that are seen once frames are put right.
The explanation of the highest likelihood is taken; another that is about as likely is told of, and the one with fewer slips taken.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import LostFrames
from identification.dataset.series import Series
from synchronisation.clocks.fine_alignment import FineAlignment
from synchronisation.clocks.lost_frame_alignment import AlignedMotion, align_with_lost_frames
from synchronisation.clocks.lost_frames import LOSS_COST, NEXT_LOSS_COST
from synchronisation.clocks.undetermined import ClockUndetermined
from synchronisation.clocks.winch_slips import MIN_SEPARATION_S, WinchSlip, find_winch_slips, without_slips
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

SLIP_COST = 30.0
"""-2 log of the probability that a cable moved on its drum: as unlikely as that a frame is missing (docs/thresholds.md)"""
MIN_LIKELIHOOD_LEAD = 30.0
"""-2 log of the ratio of likelihoods below which two explanations are both told of: one loss more or less (docs/thresholds.md)"""
MAX_SEARCHES = 3
"""times that slips are sought anew, in frames that the last fit has put right"""


@dataclass(frozen=True)
class Explanation:
    """A clock with the slips and the lost frames that it supposes."""

    slips: tuple[WinchSlip, ...]
    lost: LostFrames
    fine: FineAlignment
    warnings: tuple[str, ...]

    def log_time(self, stamp: Array) -> Array:
        """Times on the log's clock, s, of frames at their stamps, s."""
        true_time, clock = self.lost.corrected(stamp), self.fine.fit.unknowns
        return true_time + clock.offset + clock.skew * (true_time - self.fine.frames.middle)

    def cost(self, count: int) -> float:
        """-2 log of the likelihood of so many frames, but for a constant: of the cables' residuals with errors as they came out."""
        frames, fit = self.fine.frames, self.fine.fit
        whitening = frames.whitening(fit.unknowns.cable_errors(fit.rows.at_rest), fit.unknowns.noise_scale)
        white = np.einsum("fij,fj->fi", whitening, fit.residual)
        of_size = -2 * np.log(np.diagonal(whitening, axis1=1, axis2=2))
        of_frame = float(np.mean(np.sum(white**2 + of_size, axis=1)))
        of_losses = sum(LOSS_COST + NEXT_LOSS_COST * (loss.frames - 1) for loss in self.lost.losses)
        return count * of_frame + of_losses + SLIP_COST * len(self.slips)

    def words(self) -> str:
        """What it supposes."""
        moved = [
            f"cable {s.cable + 1} moved on its drum by {1e3 * s.size:+.1f} mm at {s.time:.1f} s" for s in self.slips
        ]
        count = sum(loss.frames for loss in self.lost.losses)
        lost = [f"{count} frame{'s were' if count > 1 else ' was'} lost"] if count else []
        return " and ".join([*moved, *lost]) or "no cable moved on its drum and no frame was lost"


def align_despite_slips(motion: AlignedMotion, log: Series) -> Explanation:
    """The most likely clock; log: of equal steps, as recorded.

    Raises ClockUndetermined or Refused, as `align_with_lost_frames` does, where no explanation gives a clock."""
    stamps, tried, failures = motion.frames.time, list[Explanation](), list[Refused]()

    def slips_at(frame_time: Array) -> tuple[WinchSlip, ...]:
        return find_winch_slips(motion.arm, log, motion.signals, frame_time, motion.frames.winding)

    _try(motion, log, (), tried, failures)
    at_fine = [slips_at(plain.log_time(stamps)) for plain in tried]
    if tried and not tried[0].lost.losses and not any(at_fine):
        return tried[0]
    seen: list[tuple[WinchSlip, ...]] = [()]
    for slips in (slips_at(stamps + motion.coarse.shift), *at_fine):
        for _ in range(MAX_SEARCHES):
            if any(_same(slips, other) for other in seen):
                break
            seen.append(slips)
            if not _try(motion, log, slips, tried, failures):
                break
            slips = slips_at(tried[-1].log_time(stamps))
    if not tried:
        raise _failure(failures, seen[1:])
    costs = [explanation.cost(len(stamps)) for explanation in tried]
    likely = [e for e, cost in zip(tried, costs, strict=True) if cost < min(costs) + MIN_LIKELIHOOD_LEAD]
    # of explanations that are about as likely the one with the fewest slips, then the one that was tried first
    best, *rivals = sorted(likely, key=lambda explanation: len(explanation.slips))
    doubts = [f"this is as likely: {rival.words()}" for rival in rivals if rival.words() != best.words()]
    return replace(best, warnings=(*(slip.warning() for slip in best.slips), *doubts, *best.warnings))


def _try(
    motion: AlignedMotion,
    log: Series,
    slips: tuple[WinchSlip, ...],
    tried: list[Explanation],
    failures: list[Refused],
) -> bool:
    """Adds the explanation with these slips, or why there is none; whether there is one."""
    if slips:
        gaps = (*motion.repaired.gaps, *(slip.trace for slip in slips))
        signals = without_slips(motion.arm, log, slips)
        motion = replace(motion, signals=signals, repaired=replace(motion.repaired, gaps=gaps))
    try:
        lost, fine, warnings = align_with_lost_frames(motion)
    except Refused as failure:
        failures.append(failure)
        return False
    tried.append(Explanation(slips, lost, fine, tuple(warnings)))
    return True


def _failure(failures: Sequence[Refused], slips: Sequence[tuple[WinchSlip, ...]]) -> Refused:
    """What to say where nothing gives a clock: the reason without slips, or that slips and lost frames are not told apart."""
    first = failures[0]
    if not slips or not isinstance(first, ClockUndetermined):
        return first
    return ClockUndetermined(
        "sync",
        f"cable {slips[0][0].cable + 1} seems to have moved on its drum at {slips[0][0].time:.1f} s, or frames to be lost there "
        f"without a trace, and no clock fits with either ({failures[-1].what})",
        "give both a light, or record again with the camera's own time stamps",
    )


def _same(slips: Sequence[WinchSlip], others: Sequence[WinchSlip]) -> bool:
    """Whether two searches have found the same slips: at most one fits into MIN_SEPARATION_S."""
    return len(slips) == len(others) and all(
        any(s.cable == o.cable and abs(s.time - o.time) < MIN_SEPARATION_S for o in others) for s in slips
    )
