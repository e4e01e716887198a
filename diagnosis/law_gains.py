"""Laws that nobody listed, each with what it gains on recordings that were not fitted: what gains nothing there is not told."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from diagnosis.cause_fit import CauseFitter
from diagnosis.cause_search import Search
from diagnosis.fit_stage import FitStage
from diagnosis.held_out_gain import Gain, HeldOutResiduals, gains, held_out_excess, held_out_residuals
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.noise_excess import ABOVE_NOISE_RATIO
from diagnosis.unlisted_laws import AGAINST_JOINTS, AGAINST_SEVERAL_JOINTS, as_fitted, causes_of
from discovery.found_law import FoundLaw
from mechanism.arm import Arm
from xneck_foundation.one_line import indexed
from xneck_foundation.unit_text import with_unit

MIN_LAW_GAIN_SIGMAS = 3.0
"""standard deviations of the gain, by blocks, that a law takes from recordings that were not fitted (docs/thresholds.md)"""
MIN_TAKEN_SHARE, MIN_LOUD_RATIO = 0.9, 1.5
"""... or the share that it takes of the energy above noise, in equations that were left with at least so many times noise: what
acts seldom shows in few blocks (docs/thresholds.md)"""
_TOLD_SIGMAS = 4.0
"""by which a law that was chosen out of hundreds is told from nothing"""
_OF_JOINTS = 1
"""number of the gain of the arm's equations, behind that of the motors'"""


@dataclass(frozen=True)
class GainedLaw:
    """A law that was found, and what it gains beside those found before it."""

    law: FoundLaw
    gain: Gain | None
    """in the equations that show it most, motors' or joints'; None where there is no recording that was not fitted"""

    def as_json(self) -> dict[str, Any]:
        """The contract's record."""
        return self.law.as_json() | {"gain": self.gain and self.gain.as_json()}

    @property
    def numbers_in_words(self) -> str:
        """What it is in proportion to, and its inner constants, with sigmas where they are fitted."""
        return ", ".join(
            with_unit(
                f"{indexed(p.name, p.index)} = {p.value:.4g}" + (f" +- {p.sigma:.2g}" if p.sigma else ""),
                p.unit,
            )
            for p in self.law.parameters
        )


@dataclass(frozen=True)
class LawGains:
    """The laws that hold where they were not fitted."""

    laws: tuple[GainedLaw, ...]
    stage: FitStage
    """with the causes, then the laws"""


def law_gains(
    search: Search, laws: Sequence[FoundLaw], ensembles: Sequence[NoiseEnsemble], before: HeldOutResiduals | None
) -> LawGains | None:
    """Those of laws found in what a search leaves that gain something.

    before: what it leaves of recordings that were not fitted, `ensembles`, if there are any."""
    gained = _gained(search.fitter, LawGains((), search.last), laws, ensembles, before)
    return gained if gained.laws else None


def further_law_gains(
    fitter: CauseFitter, known: LawGains, laws: Sequence[FoundLaw], ensembles: Sequence[NoiseEnsemble]
) -> LawGains | None:
    """The laws that are known, and those of others, found in what all these leave, that gain something; None where none does."""
    whiten, before = fitter.whiten, None
    if ensembles:
        before = held_out_residuals(known.stage, ensembles, whiten, clock_relaxed=True)
    gained = _gained(fitter, known, laws, ensembles, before)
    return gained if len(gained.laws) > len(known.laws) else None


def _gained(
    fitter: CauseFitter,
    known: LawGains,
    laws: Sequence[FoundLaw],
    ensembles: Sequence[NoiseEnsemble],
    before: HeldOutResiduals | None,
) -> LawGains:
    """before: what the stage of the laws that are known leaves of `ensembles`, if there are any."""
    kept, stage, arm = list(known.laws), known.stage, known.stage.before_causes.arm
    named = stage.causes[: len(stage.causes) - len(kept)]
    for law in laws:
        causes = (*named, *causes_of([*(each.law for each in kept), law], arm))
        tried = fitter.finished(fitter.fitted(known.stage.comparison.linearisation, causes))
        gain = None
        if before is not None:
            after = held_out_residuals(tried, ensembles, fitter.whiten, clock_relaxed=True)
            gained = gains(before, after, arm.M)
            is_told = len(tried.causes) - 1 not in tried.untold_within(_TOLD_SIGMAS)
            shown = _shown_in(gained, law)
            holds = _holds(gained, shown, _takes_nearly_all(before, after))
            is_better = holds and _leaves_less_beyond_noise(before, after, shown, arm)
            if not (is_better and is_told and _is_no_louder(before, after)):
                continue  # those found after it may hold without it
            gain, before = gained[shown], after
        kept, stage = [*kept, GainedLaw(law, gain)], tried
    numbered = as_fitted([each.law for each in kept], stage)
    return LawGains(tuple(replace(each, law=law) for each, law in zip(kept, numbered, strict=True)), stage)


def _shown_in(gained: Sequence[Gain], law: FoundLaw) -> int:
    """Number of the gain of those equations in which a law shows most, motors' or joints'.

    What acts at a motor changes what it pulls, so that the arm may show it where the motor's own noise hides it.
    """
    if law.candidate.detail in (AGAINST_JOINTS, AGAINST_SEVERAL_JOINTS):
        return _OF_JOINTS
    return int(np.argmax([(g.before - g.after) / g.sigma if g.sigma else -np.inf for g in gained[: _OF_JOINTS + 1]]))


def _holds(gained: Sequence[Gain], shown: int, takes_nearly_all: bool) -> bool:
    """Whether the equations that show it are left with less, and the others with no more."""
    own = gained[shown]
    better = own.before - own.after > MIN_LAW_GAIN_SIGMAS * own.sigma or takes_nearly_all
    # a law of nearly the right form may leave a little in equations that noise fills
    worse = any(
        g.after - g.before > MIN_LAW_GAIN_SIGMAS * g.sigma and g.after > ABOVE_NOISE_RATIO * g.noise_floor
        for g in gained
    )
    return better and not worse and np.isfinite(own.after)


def _takes_nearly_all(before: HeldOutResiduals, after: HeldOutResiduals) -> bool:
    """Whether hardly more than noise is left of what was plain, in however few blocks: no chance foretells that."""
    old, new = (held_out_excess(side, after).ratio for side in (before, after))
    loud = old > MIN_LOUD_RATIO
    energy, left = (float(np.sum(ratio[loud] ** 2 - 1)) for ratio in (old, new))
    return left < (1 - MIN_TAKEN_SHARE) * energy


def _leaves_less_beyond_noise(before: HeldOutResiduals, after: HeldOutResiduals, shown: int, arm: Arm) -> bool:
    """Whether the equations that show it are left with less beyond the noise that each model itself makes of the measurements.

    A law that makes forces smaller makes all that is wrong smaller with them, and noise more so."""
    of_law = slice(arm.M, None) if shown == _OF_JOINTS else slice(0, arm.M)
    left, was_left = (
        float(np.sum((excess.rms**2 - excess.floor**2)[of_law]))
        for excess in (held_out_excess(after, after), held_out_excess(before, before))
    )
    return left < was_left


def _is_no_louder(before: HeldOutResiduals, after: HeldOutResiduals) -> bool:
    """Whether noise with a law is in every equation as soft as what was left without: louder noise would hide anything."""
    floor, was_left = held_out_excess(after, after).floor, held_out_excess(before, before).rms
    return bool(np.all(floor < ABOVE_NOISE_RATIO * was_left))
