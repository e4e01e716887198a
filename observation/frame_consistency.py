"""Whether frames are of the log that an observer goes through: what each of them stands beside what motors tell of the joints.

A constant beside the joints is a zero that was set anew, and what follows neither time nor sense is a model that lacks something:
of both the motors' own forces tell (health.py), so that no frame is blamed for them. Frames on another clock stand beside the
joints as these move, and frames of another recording, with turned signs or exchanged joints, by as much as the joints move.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from observation.observer import Innovation
from observation.pose_time import POSE_TIME_S
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed

Array = NDArray[np.float64]

FALSE_ALARM = 1e-6
"""share of right frames of a right model whose chi-square is too large (docs/thresholds.md)"""
MIN_FRAMES = 4
"""frames from which on they are judged (docs/thresholds.md)"""
MIN_CLOCK_ERROR_S = 5e-3
"""s by which frames must be early or late to be said to be so: damping that no law has looks like less (docs/thresholds.md)"""
MIN_CLOCK_SHARE = 0.75
"""share of what is beyond chance that another clock must explain (docs/thresholds.md)"""
MAX_BESIDE_SHARE = 0.7
"""of the rms by which a joint moves in the frames: what stands beside it by more does not follow it (docs/thresholds.md)"""


@dataclass(frozen=True)
class FrameConsistency:
    """Frames beside the joints that motors tell, but for a constant of each joint."""

    misfit: float
    """mean of squares, in units of what is expected: one where frames and model are as they say"""
    limit: float
    """of the misfit, that right frames exceed by FALSE_ALARM"""
    clock_error_s: float
    """s by which the frames' stamps are late"""
    clock_share: float
    """of what is beyond chance, that this explains"""
    beside: Array
    """(N,), rad, RMS"""
    moved: Array
    """(N,), rad, RMS, of the angles in the frames or as motors tell them, whichever is less"""

    def check(self) -> None:
        """Raises Refused where the frames are on another clock, or of another motion."""
        if self.misfit <= self.limit:
            return
        if self.clock_share > MIN_CLOCK_SHARE and abs(self.clock_error_s) > MIN_CLOCK_ERROR_S:
            word = "late" if self.clock_error_s > 0 else "early"
            raise Refused(
                "frames",
                f"their times are about {1e3 * abs(self.clock_error_s):.0f} ms {word} on this log's clock: so they stand "
                f"{self._beside_words(range(len(self.beside)))} beside the joints that the motors tell",
                "give the data set that `xneck sync` makes of frames and log, or times on the log's clock",
            )
        astray = np.flatnonzero(self.beside > MAX_BESIDE_SHARE * self.moved)
        if len(astray):
            raise Refused(
                "frames",
                f"they do not fit this log: {listed(f'alpha{i + 1}' for i in astray)} stand {self._beside_words(astray)} beside "
                "the joints that the motors tell, as much as they move",
                "are they of this recording and on this log's clock, with the signs and order of the model's joints?",
            )

    @property
    def doubt(self) -> str | None:
        """For a person, where frames that were not refused stand further beside the joints than chance has it."""
        if self.misfit <= self.limit:
            return None
        return (
            f"frames stand {self._beside_words(range(len(self.beside)))} beside the joints that the motors tell, about a "
            f"constant: {np.sqrt(self.misfit):.1f} times what they and the model are said to be good for; is their scale "
            "right, and their sigma?"
        )

    def _beside_words(self, joints: Sequence[int] | NDArray[np.intp]) -> str:
        low, high = (np.degrees(pick([self.beside[i] for i in joints])) for pick in (min, max))
        return f"{high:.2g} deg (rms)" if f"{low:.2g}" == f"{high:.2g}" else f"{low:.2g} to {high:.2g} deg (rms)"


def frame_consistency(time: Sequence[float], innovations: Sequence[Innovation]) -> FrameConsistency | None:
    """Of frames at times (F,), s; None where they are too few to tell."""
    if len(innovations) < MIN_FRAMES:
        return None
    beside, variance, alpha, alpha_d = (
        np.array([getattr(one, name) for one in innovations]) for name in ("beside", "variance", "alpha", "alpha_d")
    )
    known = np.isfinite(beside)
    weight = np.where(known, 1 / variance, 0.0)
    enough = known.sum(axis=0) >= MIN_FRAMES
    if not enough.any():
        return None
    e, rates, seen, told = (_about_mean(part, weight) for part in (beside, alpha_d, alpha + beside, alpha))
    # errors of the pose last, so that frames within that time are not independent
    independent = min(len(time) - 1.0, (time[-1] - time[0]) / POSE_TIME_S)
    count = float((known.sum(axis=0) - 1)[enough].sum())
    degrees = max(independent, 1.0) * enough.sum()
    before = float(np.sum(weight * e**2))
    late = -float(np.sum(weight * rates * e)) / max(float(np.sum(weight * rates**2)), 1e-300)
    after = float(np.sum(weight * (e + late * rates) ** 2))
    used = np.maximum(known.sum(axis=0), 1)
    return FrameConsistency(
        misfit=before / count,
        limit=float(chi2.isf(FALSE_ALARM, degrees) / degrees),
        clock_error_s=late,
        clock_share=(before - after) / max(before - count, 1e-300),
        beside=np.sqrt(np.sum(e**2, axis=0) / used),
        moved=np.sqrt(np.minimum(np.sum(seen**2, axis=0), np.sum(told**2, axis=0)) / used),
    )


def _about_mean(values: Array, weight: Array) -> Array:
    """Values (F, N) less each joint's weighted mean; zero where the weight is."""
    known = np.where(weight > 0, values, 0.0)
    mean = np.sum(weight * known, axis=0) / np.maximum(np.sum(weight, axis=0), 1e-300)
    return np.where(weight > 0, known - mean, 0.0)
