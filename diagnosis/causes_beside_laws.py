"""Causes of the catalogue beside a law that nobody listed.

Where such a law acts no choice of causes is right: some stand in for it, and what is there besides does not show. Once it is known,
causes are sought anew beside it, and all is fitted together.
"""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.cause import Cause, with_causes
from diagnosis.cause_choice import share_that_causes_leave
from diagnosis.cause_fit import fitted_without
from diagnosis.cause_search import MAX_SHARE_OF_OTHER_FORM, Search, search_causes
from diagnosis.fit_stage import FitStage
from diagnosis.held_out_gain import HeldOutResiduals, held_out_residuals
from diagnosis.law_gains import GainedLaw, LawGains, further_law_gains, law_gains
from diagnosis.noise_columns import noise_columns
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.remainder import leaves_plainly_more
from diagnosis.shown_by import FORCE, JOINT_ANGLE, JOINT_SPEED, MOTOR_SPEED, TENSION, ShownBy
from diagnosis.unlisted_laws import as_fitted, found_laws
from diagnosis.worth_naming import MIN_LOSS_SHARE
from discovery.form import SMOOTH
from discovery.found_law import FoundLaw

MAX_SHARE_LEFT = 0.5
"""of what stands above noise: laws found in the place of causes leave no more of it, else the causes stay (docs/thresholds.md)"""

_VARIABLES: Mapping[str, ShownBy] = {
    "force": FORCE,
    "tension": TENSION,
    "motor_speed": MOTOR_SPEED,
    "joint_angle": JOINT_ANGLE,
    "joint_speed": JOINT_SPEED,
}
"""of laws, that causes are functions of as well"""
_AT_LEAST = 1e-6
"""of an amount's size, within which it is the least that it may be"""


@dataclass(frozen=True)
class Explanation:
    """What explains recordings: causes, and laws that nobody listed."""

    search: Search
    laws: tuple[GainedLaw, ...]
    stage: FitStage
    """with the causes, then the laws"""

    @property
    def is_sound(self) -> bool:
        """Whether each law stands off nothing by its sigma as it is told, which what is left widens; where there is none, whether
        causes leave little more than noise."""
        if not self.laws:
            return not leaves_plainly_more(self.stage.excess)
        first_law = len(self.stage.causes) - len(self.laws)
        return all(i < first_law for i in self.stage.untold_beside_what_is_left)

    @property
    def number_count(self) -> int:
        """Of the causes and the laws."""
        return sum(cause.number_count for cause in self.stage.causes)

    @property
    def may_be_one_law(self) -> bool:
        """Whether the only cause has as little of something as it may, as dry friction that pushes, and a law is of its variable.

        Both may stand for one law of another form."""
        if len(self.search.named) != 1:
            return False
        cause = self.stage.causes[0]
        has_least = bool(np.any(cause.least_steps(self.stage.before_causes.arm) > -_AT_LEAST))
        return has_least and any(
            _VARIABLES.get(each.law.candidate.variable) is cause.effect.shown_by for each in self.laws
        )


def with_laws(
    search: Search,
    left: HeldOutResiduals | None,
    recordings: Sequence[NoiseEnsemble],
    others: Sequence[NoiseEnsemble],
    seed: int,
) -> Explanation:
    """Laws in what a search leaves; beside other causes, or in the place of all, where these leave plainly more than noise.

    left: what the search leaves of `others`, which were not fitted, if there are any; recordings: those that were."""
    best = _beside_causes(search, left, recordings, seed, others)
    best = best if best.is_sound else Explanation(search, (), search.last)
    if best.may_be_one_law and not leaves_plainly_more(best.stage.excess):
        alone = search.without_causes()
        instead = _beside_causes(alone, _left_of(alone, others), recordings, seed, others)
        explains_as_well = instead.is_sound and not leaves_plainly_more(instead.stage.excess)
        if explains_as_well and instead.number_count < best.number_count:
            return instead
    if search.named and search.last.excess.share_of(search.first.excess) < MAX_SHARE_OF_OTHER_FORM:
        return best  # no other causes, or none, would be right
    tried = _with_other_causes(search)  # each is fitted when it is asked for
    while leaves_plainly_more(best.stage.excess) and (other := next(tried, None)) is not None:
        instead = _beside_causes(other, _left_of(other, others), recordings, seed, others)
        if instead.is_sound and instead.stage.excess.share_of(best.stage.excess) < MAX_SHARE_LEFT:
            best = instead
    return best


def _with_other_causes(search: Search) -> Iterator[Search]:
    """With those that took too little to be named; with one of several, where the others may stand in for a law; with none."""
    if outweighed := search.with_outweighed_causes():
        yield outweighed
    if len(search.named) > 1:
        yield search.with_one_cause()
    if search.named:
        yield search.without_causes()


def _beside_causes(
    search: Search,
    left: HeldOutResiduals | None,
    recordings: Sequence[NoiseEnsemble],
    seed: int,
    others: Sequence[NoiseEnsemble],
) -> Explanation:
    """The laws that are found beside a search's causes, and the causes that are found beside some of them.

    Causes are sought beside the first law alone before there are others: what else it leaves may be theirs, and further laws only
    stand in for them. But what has no simple form may itself stand in for them, where they are functions of its variable."""
    fitter = search.fitter
    growing = found_laws(search.last, fitter.whiten, noise_columns(search.last, fitter.ensembles), seed)
    found = law_gains(search, next(growing, ()), others, left)
    tried: dict[str, Explanation | None] = {}
    if found and leaves_plainly_more(found.stage.excess) and not _may_be_causes(found.laws[0].law):
        beside = _causes_beside(search, found, [0], recordings, seed, others)
        if beside is not None and _is_enough(beside, found):
            return beside
        tried[found.laws[0].law.words] = beside
    if every := deque(growing, maxlen=1):
        found = law_gains(search, every[0], others, left)
    if found is None:
        return Explanation(search, (), search.last)
    alone = Explanation(search, found.laws, found.stage)
    # of several laws one may be a cause that did not show before: friction of joints is a saturating function of their speed
    if not (search.named or found.stage.excess.above_noise or len(found.laws) > 1):
        return alone
    for held in _held(found):
        words = ", ".join(found.laws[i].law.words for i in held)
        beside = tried[words] if words in tried else _causes_beside(search, found, held, recordings, seed, others)
        if beside is not None:
            return beside
    return alone


def _held(found: LawGains) -> Iterator[list[int]]:
    """Numbers of the laws beside which causes are sought: those that have a simple form, if the first has none, then the first.

    What has no simple form may stand in for a cause and for the laws that were found after it.
    The first is not held alone where others are of the same variable: together they are one function of it."""
    has_form = [i for i, each in enumerate(found.laws) if each.law.form.name != SMOOTH]
    if has_form and 0 not in has_form:
        yield has_form
    first = found.laws[0].law.candidate
    yield [i for i, each in enumerate(found.laws) if each.law.candidate.is_sibling(first)]


def _is_enough(beside: Explanation, found: LawGains) -> bool:
    """Whether what causes beside laws leave is noise, or so much less than the laws alone that no others would be right."""
    left = beside.stage.excess
    return not leaves_plainly_more(left) or left.share_of(found.stage.excess) < MAX_SHARE_OF_OTHER_FORM


def _causes_beside(
    search: Search,
    found: LawGains,
    held: Sequence[int],
    recordings: Sequence[NoiseEnsemble],
    seed: int,
    others: Sequence[NoiseEnsemble],
) -> Explanation | None:
    """Causes beside some of the laws that were found, where they are others than a search has and leave no more than all laws.

    While the laws' numbers stayed as they were found, some causes may not have shown: with numbers that were fitted beside the
    first ones causes are sought from these on, where straight lines promise any, else another law, as long as that explains much
    more."""
    first = LawGains(tuple(found.laws[i] for i in held), found.stage)
    count = len(search.last.causes)
    laws = [found.stage.causes[count + i] for i in held]
    best = _causes_found_beside(search, first, laws, (), recordings, seed)
    while best is not None and best.laws and leaves_plainly_more(best.stage.excess):
        more: Explanation | None = None
        if share_that_causes_leave(best.stage, best.search.fitter.whiten, seed) < MAX_SHARE_LEFT:
            count = len(best.search.named)
            named, laws = best.stage.causes[:count], best.stage.causes[count:]
            more = _causes_found_beside(best.search, LawGains(best.laws, best.stage), laws, named, recordings, seed)
        if more is None or more.stage.excess.share_of(best.stage.excess) > MAX_SHARE_LEFT:
            more = _with_another_law(best, others, seed)
        if more is None or more.stage.excess.share_of(best.stage.excess) > MAX_SHARE_LEFT:
            break
        best = more
    return best


def _with_another_law(best: Explanation, others: Sequence[NoiseEnsemble], seed: int) -> Explanation | None:
    """With the law that is found in what causes and laws leave; None where none is, or gains nothing."""
    fitter, known = best.search.fitter, LawGains(best.laws, best.stage)
    more = next(found_laws(best.stage, fitter.whiten, noise_columns(best.stage, fitter.ensembles), seed), ())
    gained = further_law_gains(fitter, known, more, others) if more else None
    return replace(best, laws=gained.laws, stage=gained.stage) if gained else None


def _causes_found_beside(
    search: Search,
    found: LawGains,
    laws: Sequence[Cause],
    begun: tuple[Cause, ...],
    recordings: Sequence[NoiseEnsemble],
    seed: int,
) -> Explanation | None:
    """As `_causes_beside`, once. laws: those of `found`, with numbers; begun: causes from which on others are sought."""
    h, at = with_causes(found.stage.before_causes, laws), found.stage.comparison.linearisation
    beside = search_causes(h, recordings, seed, found.stage.excess, begun)
    if _names(beside) == _names(search) or not beside.last.possible:
        return None
    fitter, named, last = search.fitter, beside.named, beside.last
    stage = fitter.fitted(at, (*beside.last.causes, *laws))
    # while the law's numbers stayed as they were found, causes may have made good for them
    while 0 < len(untold := [i for i in stage.untold if i < len(named)]) < len(named):
        stage, last = fitted_without(fitter, stage, untold), fitted_without(beside.fitter, last, untold)
        named = tuple(cause for i, cause in enumerate(named) if i not in untold)
    fitter, stage = fitter.with_own_weights(stage)
    stage = fitter.finished(stage)
    alone = fitted_without(fitter, stage, range(len(named), len(stage.causes)))
    takes = alone.surplus - stage.surplus
    if alone.possible and not leaves_plainly_more(alone.excess) and takes < MIN_LOSS_SHARE * alone.noise_loss:
        # the laws only stood in for causes that did not show
        alone = fitter.finished(alone)
        without = replace(search, named=named, last=alone, fitter=fitter, unlisted=None)
        return Explanation(without, (), alone)
    leaves_more = stage.excess.above_noise and stage.surplus > found.stage.surplus
    if leaves_more or not stage.possible:
        return None
    numbered = as_fitted([each.law for each in found.laws], stage)
    other = replace(search, named=named, last=last, fitter=fitter, unlisted=beside.unlisted)
    return Explanation(other, tuple(replace(each, law=n) for each, n in zip(found.laws, numbered, strict=True)), stage)


def _may_be_causes(law: FoundLaw) -> bool:
    """Whether a law has no simple form, and causes are functions of its variable."""
    return law.form.name == SMOOTH and law.candidate.variable in _VARIABLES


def _names(search: Search) -> set[tuple[str, str]]:
    return {(cause.effect.name, cause.where.label) for cause in search.named}


def _left_of(search: Search, others: Sequence[NoiseEnsemble]) -> HeldOutResiduals | None:
    """What a search leaves of recordings that were not fitted, if there are any."""
    if not others:
        return None
    return held_out_residuals(search.last, others, search.fitter.whiten, clock_relaxed=bool(search.last.causes))
