"""Laws that nobody listed, each with what it gains on recordings that were not fitted: what gains nothing there is not told."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from diagnosis.cause import with_causes
from diagnosis.cause_search import Search
from diagnosis.held_out_gain import Gain, HeldOutResiduals, gains, held_out_residuals
from diagnosis.hypothesis import Hypothesis
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.unlisted_laws import unlisted_laws
from discovery.found_law import FoundLaw

MIN_LAW_GAIN_SIGMAS = 3.0
"""standard deviations of the gain, by blocks, that a law takes from recordings that were not fitted (docs/thresholds.md)"""


@dataclass(frozen=True)
class GainedLaw:
    """A law that was found, and what it gains beside those found before it."""

    law: FoundLaw
    gain: Gain | None
    """in the equations where it acts; None where there is no recording that was not fitted"""

    def as_json(self) -> dict[str, Any]:
        """The contract's record."""
        return self.law.as_json() | {"gain": self.gain and self.gain.as_json()}

    @property
    def numbers_in_words(self) -> str:
        """What it is in proportion to, and its inner constants, with sigmas where they are fitted."""
        return ", ".join(
            f"{p.name}{'' if p.index is None else f'({p.index})'} = {p.value:.4g}"
            + (f" +- {p.sigma:.2g}" if p.sigma else "")
            + (f" {p.unit}" if p.unit != "1" else "")
            for p in self.law.parameters
        )


@dataclass(frozen=True)
class LawGains:
    """The laws that hold where they were not fitted."""

    laws: tuple[GainedLaw, ...] = ()
    residuals: HeldOutResiduals | None = None
    """of recordings that were not fitted, with all of these; None where there is no such law or recording"""


def law_gains(
    search: Search, h: Hypothesis, ensembles: Sequence[NoiseEnsemble], before: HeldOutResiduals | None, seed: int
) -> LawGains:
    """Laws in what a search leaves; before: what it leaves of recordings that were not fitted, `ensembles`, if there are any."""
    last, whiten = search.last, search.fitter.whiten
    extended = with_causes(h, last.causes)
    kept: list[GainedLaw] = []
    for found in unlisted_laws(last, whiten, seed):
        law = found.laws[-1]
        if before is None:
            kept = [GainedLaw(each, None) for each in found.laws]
            continue
        after = held_out_residuals(
            last.comparison,
            found.fit,
            extended,
            last.causes,
            ensembles,
            whiten,
            clock_relaxed=True,
            laws=[found.effect],
        )
        gained = gains(before, after, h.arm.M)
        if not _holds(gained, law):
            break
        own = gained[_equations_of(law)]
        kept = [*(GainedLaw(each, old.gain) for each, old in zip(found.laws, kept, strict=False)), GainedLaw(law, own)]
        before = after
    return LawGains(tuple(kept), before if kept else None)


def _equations_of(law: FoundLaw) -> int:
    """Number of the gain that is of the equations in which it acts."""
    return int(law.candidate.target_unit == "N m")


def _holds(gained: Sequence[Gain], law: FoundLaw) -> bool:
    """Whether its equations are left with less, and the others with no more."""
    own = gained[_equations_of(law)]
    better = own.before - own.after > MIN_LAW_GAIN_SIGMAS * own.sigma
    worse = any(g.after - g.before > MIN_LAW_GAIN_SIGMAS * g.sigma for g in gained)
    return better and not worse and np.isfinite(own.after)
