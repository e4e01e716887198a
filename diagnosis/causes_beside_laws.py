"""Causes of the catalogue beside a law that nobody listed.

Where such a law acts no choice of causes is right: some stand in for it, and what is there besides does not show. Once it is known,
causes are sought anew beside it, and all is fitted together.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diagnosis.cause import with_causes
from diagnosis.cause_search import Search, search_causes
from diagnosis.fit_stage import FitStage
from diagnosis.held_out_gain import HeldOutResiduals, held_out_residuals
from diagnosis.law_gains import GainedLaw, law_gains
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.remainder import MAX_REMAINDER
from diagnosis.unlisted_laws import as_fitted

MAX_SHARE_LEFT = 0.5
"""of what stands above noise: laws found in the place of causes leave no more of it, else the causes stay (docs/thresholds.md)"""


@dataclass(frozen=True)
class Explanation:
    """What explains recordings: causes, and laws that nobody listed."""

    search: Search
    laws: tuple[GainedLaw, ...]
    stage: FitStage
    """with the causes, then the laws"""


def with_laws(
    search: Search,
    left: HeldOutResiduals | None,
    recordings: Sequence[NoiseEnsemble],
    others: Sequence[NoiseEnsemble],
    seed: int,
) -> Explanation:
    """Laws in what a search leaves, or in the place of its causes where these leave plainly more than noise, or none.

    left: what the search leaves of `others`, which were not fitted, if there are any; recordings: those that were."""
    found = _beside_causes(search, left, recordings, seed, others)
    if not search.named or found.stage.excess.ratio.max() < MAX_REMAINDER:
        return found
    base = search.without_causes()
    instead = _beside_causes(base, _left_of(base, others), recordings, seed, others)
    leaves_less = instead.stage.excess.energy < MAX_SHARE_LEFT * found.stage.excess.energy
    return instead if instead.laws and leaves_less else found


def _beside_causes(
    search: Search,
    left: HeldOutResiduals | None,
    recordings: Sequence[NoiseEnsemble],
    seed: int,
    others: Sequence[NoiseEnsemble],
) -> Explanation:
    """The laws that are found beside a search's causes, and the causes that are found beside the first of them."""
    found = law_gains(search, others, left, seed)
    if found is None:
        return Explanation(search, (), search.last)
    alone = Explanation(search, found.laws, found.stage)
    if not (search.named or found.stage.excess.above_noise):
        return alone
    law = found.stage.causes[len(search.last.causes)]
    beside = search_causes(with_causes(search.fitter.hypothesis, [law]), recordings, seed)
    if _names(beside) == _names(search) or not beside.last.possible:
        return alone
    fitter = search.fitter
    stage = fitter.fitted(found.stage.comparison.linearisation, (*beside.last.causes, law))
    if fitter.is_ill_weighted(stage):
        fitter, stage = fitter.reweighted(stage)
    stage = fitter.finished(stage)
    leaves_more = stage.excess.above_noise and stage.excess.energy > found.stage.excess.energy
    if leaves_more or not stage.possible:
        return alone
    (first, *_) = found.laws
    (numbered,) = as_fitted([first.law], stage)
    other = replace(search, named=beside.named, last=beside.last, fitter=fitter, unlisted=beside.unlisted)
    return Explanation(other, (replace(first, law=numbered),), stage)


def _names(search: Search) -> set[tuple[str, str]]:
    return {(cause.effect.name, cause.where.label) for cause in search.named}


def _left_of(base: Search, others: Sequence[NoiseEnsemble]) -> HeldOutResiduals | None:
    """What the base model leaves of recordings that were not fitted, if there are any."""
    if not others:
        return None
    first, h = base.first, base.fitter.hypothesis
    return held_out_residuals(first.comparison, first.fit, h, (), others, base.fitter.whiten, clock_relaxed=False)
