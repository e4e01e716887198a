"""Which causes explain what the base model does not, as many as the recordings carry.

They are chosen jointly by straight lines (diagnosis/stepwise.py), fitted together, and chosen anew where they then are: each takes
a part worth naming of what stands above noise, and more than any would by chance. What is known to a tolerance is a cause where
it lies further beyond than chance puts any. A cause that the others make needless is given up. In the end those that explained
about as much are fitted in its place; with it go all that leave little more: data cannot tell these apart. Of two that explain
as much the one with fewer numbers stands for both.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause
from diagnosis.cause_fit import CauseFitter
from diagnosis.compare import compare
from diagnosis.comparison import Comparison, Index
from diagnosis.effect import Effect, Placement, Shape
from diagnosis.effects import EFFECTS
from diagnosis.elimination import eliminated
from diagnosis.fit_stage import FitStage
from diagnosis.free_function import FreeFit, FreeFits
from diagnosis.hypothesis import Hypothesis
from diagnosis.noise_ensemble import NoiseEnsemble
from diagnosis.remainder import leaves_plainly_more
from diagnosis.stepwise import Choices, Option, Simpler, best_addition, chosen_jointly
from identification.whitening import Whitener
from mechanism.laws import law_named
from mechanism.laws.unlisted import UnlistedLaw

Array = NDArray[np.float64]

MIN_LOSS_SHARE = 0.08
"""of the loss: what a cause must take away at least (docs/thresholds.md)"""
SINGLE_PLACE_SHARE = 0.95
"""of what an effect explains everywhere: a place that explains as much has it alone (docs/thresholds.md)"""
MIN_EXPLAINED = 0.6
"""of the loss beyond noise: what all causes together take away at least, else none is named (docs/thresholds.md)"""
MIN_EXPLAINED_NEXT = 0.1
"""of what still stands above noise: what a cause takes away at least (docs/thresholds.md)"""
MAX_SHARE_OF_UNLISTED = 0.5
"""of what all causes leave above noise: a function of one variable that leaves less in their place takes their place
(docs/thresholds.md)"""
MAX_SHARE_OF_LAW = 0.25
"""of what a further cause leaves: a function of one variable that leaves less in its place ends the choice (docs/thresholds.md)"""
KEPT_SHARE = 0.5
"""of what a cause must take to be added: what takes less beside causes that came after it is needless (docs/thresholds.md)"""
CHANCE_LEVEL = 0.01
"""share of worlds of noise and a drawing's errors alone in which the most telling of all causes may seem to explain as much
(docs/thresholds.md)"""
_CHANCE_WORLDS = 400
_MAX_RIVALS = 4
"""causes that are fitted in the place of the best one, itself among them (docs/thresholds.md)"""
_RIVAL_SHARE = 0.7
"""of what a cause takes: what another one must take in its place to be fitted there (docs/thresholds.md)"""
_RIVAL_REACH = 3.0
"""times what causes may differ by that explain alike: how much more another one leaves at most that is fitted in its place
(docs/thresholds.md)"""
_MAX_AT_ONCE = 4
"""causes that are added at once; where straight lines would have more, the best one comes first (docs/thresholds.md)"""
_MAX_CHOICES = 12
"""of causes, each fitted before the next"""
_TIE_BY_CHANCE = 6.0
"""of the loss: causes whose fits differ by less may both be the one, by chance (docs/thresholds.md)"""
_SIMPLER_SHARE = 0.1
"""of the gain: by so much less, fewer numbers are worth as much (docs/thresholds.md)"""


@dataclass(frozen=True)
class CauseCandidate:
    """An effect in its best shape and place, its columns, and what it takes from the loss."""

    effect: Effect
    shape: Shape
    where: Placement
    columns: Index
    gain: float
    """of blocks that it was not fitted to, and of nuisances that need not go so far"""
    number_count: int
    """of numbers that it is fitted by"""


@dataclass(frozen=True)
class Rival:
    """A cause that explains as much, and the loss with it beyond noise."""

    effect: Effect
    where: Placement
    surplus: float


@dataclass(frozen=True)
class NamedCause:
    """A cause, those that explain as much with itself as the first, and the loss before it."""

    effect: Effect
    where: Placement
    tied: tuple[Rival, ...]
    gain: float
    """what it takes from the loss"""
    loss: float
    """with it"""

    @property
    def loss_before(self) -> float:
        """Without it."""
        return self.loss + self.gain


@dataclass(frozen=True)
class Search:
    """Where it began, where it ended, and what was named on the way."""

    first: FitStage
    last: FitStage
    named: tuple[NamedCause, ...]
    every_effect: Comparison
    """the first stage with all effects beside it"""
    ranking: tuple[CauseCandidate, ...]
    """of every effect by itself beside the first stage, the best first"""
    fitter: CauseFitter
    """with the weights of the last stage"""
    unlisted: FreeFit | None
    """the function of one variable that explains most of what the causes leave plainly above noise, if they do"""
    free_fits: FreeFits
    """those that were looked for"""
    outweighed: FitStage | None = None
    """with causes that take too little to be named by themselves, if there are any"""

    def with_outweighed_causes(self) -> "Search | None":
        """With causes that take too little to be named by themselves: beside a law that nobody listed they may be right."""
        if self.outweighed is None:
            return None
        causes, last = _with_look_alikes(self.fitter, self.outweighed)
        return self._ending(self.fitter.finished(last), causes)

    def without_causes(self) -> "Search":
        """As it began."""
        return self._ending(self.first, ())

    def without_the_least(self) -> "Search":
        """Without the cause that takes least; without any where the others leave too much."""
        least = min(range(len(self.named)), key=lambda i: self.named[i].gain)
        if len(self.named) == 1:
            return self.without_causes()
        last = self.fitter.finished(_without(self.fitter, self.last, [least]))
        if last.excess.above_noise and _is_outweighed(self.first, last, self.fitter.whiten, self.free_fits):
            return self.without_causes()
        return self._ending(last, (*self.named[:least], *self.named[least + 1 :]))

    def with_one_cause(self) -> "Search":
        """With the one of its causes beside which a function of one variable leaves least."""
        everything = range(len(self.named))
        alone = [_without(self.fitter, self.last, [k for k in everything if k != i]) for i in everything]
        left = [self.free_fits.best(stage, self.fitter.whiten) for stage in alone]
        best = min(everything, key=lambda i: (left[i] or alone[i]).excess.energy)
        return self._ending(self.fitter.finished(alone[best]), (self.named[best],))

    def _ending(self, last: FitStage, named: tuple[NamedCause, ...]) -> "Search":
        return replace(self, named=named, last=last, unlisted=_unlisted(last, self.fitter.whiten, self.free_fits))


def search_causes(h: Hypothesis, ensembles: Sequence[NoiseEnsemble], seed: int = 0) -> Search:
    """Causes beyond a hypothesis in recordings of one arm. Raises Refused where a motor stands still."""
    fitter = CauseFitter(h, ensembles)
    fitter, first = fitter.redrawn(fitter.base_model())
    every_effect = _with_effects(first, fitter.whiten)
    ranked = rank(every_effect)
    free_fits = FreeFits()
    fitter, last = _with_all_causes(fitter, first, every_effect, free_fits, seed)
    outweighed: FitStage | None = None
    knows_a_law = any(isinstance(law_named(name), UnlistedLaw) for name in h.laws)
    if not knows_a_law and last.excess.above_noise and _is_outweighed(first, last, fitter.whiten, free_fits):
        # a law whose numbers stay as they were found leaves more beside the right causes than one more law would
        outweighed, last = last if last.causes else None, first
    causes, last = _with_look_alikes(fitter, last)
    if causes and last.excess.above_noise:
        fitter, last = fitter.reweighted_by_what_is_left(last)
    elif causes:
        fitter, last = fitter.reweighted(last)
    if causes:
        last = fitter.finished(last)
        if len(last.untold) == len(causes) and not first.excess.above_noise:
            causes, last = (), first
        elif told := _without_untold(fitter, last):
            causes = tuple(cause for i, cause in enumerate(causes) if i not in last.untold)
            last = fitter.finished(told)
        if leaves_plainly_more(last.excess) and len(last.untold_beside_what_is_left) == len(causes):
            causes, last = (), first  # they stand in for something else
    return Search(
        first=first,
        last=last,
        named=causes,
        every_effect=every_effect,
        ranking=tuple(ranked),
        fitter=fitter,
        unlisted=_unlisted(last, fitter.whiten, free_fits),
        free_fits=free_fits,
        outweighed=outweighed,
    )


def _unlisted(stage: FitStage, whiten: Whitener, free_fits: FreeFits) -> FreeFit | None:
    return free_fits.best(stage, whiten) if leaves_plainly_more(stage.excess) else None


def _is_outweighed(first: FitStage, last: FitStage, whiten: Whitener, free_fits: FreeFits) -> bool:
    """Whether what causes leave is more than they may, or far more than a law that nobody listed would leave in their place."""
    if last.excess.energy > (1 - MIN_EXPLAINED) * first.excess.energy:
        return True
    if not leaves_plainly_more(last.excess):
        return False
    unlisted = free_fits.best(first, whiten)
    return unlisted is not None and unlisted.excess.energy < MAX_SHARE_OF_UNLISTED * last.excess.energy


def _with_all_causes(
    fitter: CauseFitter, first: FitStage, every_effect: Comparison, free_fits: FreeFits, seed: int
) -> tuple[CauseFitter, FitStage]:
    """Causes chosen jointly, fitted together, and chosen anew where they then are, until the choice stands.

    A wrong model's noise is another one: weights are told anew where that of a better one is. What was given up beside other
    causes is offered once more before the choice stands: what they did not explain may have driven it where nothing can be."""
    last, given_up, beside = first, dict[str, FitStage](), every_effect
    for _ in range(_MAX_CHOICES):
        by_chance = _by_chance(beside, last.causes, seed)
        choices, offered = _choices(last, beside, given_up)
        start, least_gains = list(range(len(last.causes))), _least_gains(last, offered, by_chance)
        simpler = _simpler(last)
        chosen = chosen_jointly(choices, start, least_gains, simpler)
        if sorted(chosen) == start:
            after = _without_a_needless_one(fitter, last, choices, least_gains)
            after = after or _with_one_far_off(fitter, last, choices, offered, by_chance)
        else:
            added = [i for i in chosen if i not in start]
            alone = best_addition(choices, start, least_gains, simpler) if len(added) > 1 else None
            if alone is not None and len(added) > _MAX_AT_ONCE:
                # so many stand in for the bend of one, and take minutes to fit
                chosen, added, alone = [*start, alone], [alone], None
            joint = fitter.fitted(last.comparison.linearisation, tuple(offered[i] for i in sorted(chosen)))
            after = _without_impossible(fitter, joint)
            if alone is not None and not _is_better(after, last, by_chance):
                # where straight lines mislead, one cause may, and take a right one with it
                after = fitter.fitted(last.comparison.linearisation, tuple(offered[i] for i in [*start, alone]))
            only_lost = after is not joint and _places(after) == _places(last)
            if only_lost or not _is_better(after, last, by_chance):
                if added:
                    given_up |= {offered[i].effect.name: last for i in added}
                    continue
                after = _without_the_least(fitter, last, choices, [i for i in start if i not in chosen], by_chance)
        if after is None:
            here = {name: stage for name, stage in given_up.items() if stage is last}
            if len(here) == len(given_up) or not last.excess.above_noise:
                break
            given_up = here
            continue
        if _a_law_would_do(last, after, fitter.whiten, free_fits):
            break
        last = after
        if fitter.is_ill_weighted(last):
            fitter, last = fitter.reweighted(last)
        beside = _with_effects(last, fitter.whiten)
    return fitter, last


def _a_law_would_do(last: FitStage, after: FitStage, whiten: Whitener, free_fits: FreeFits) -> bool:
    """Whether causes that come to others leave far more than a law that nobody listed would: they only stand in for it."""
    if not len(after.causes) > len(last.causes) > 0 or not leaves_plainly_more(after.excess):
        return False
    unlisted = free_fits.best(last, whiten)
    return unlisted is not None and unlisted.excess.energy < MAX_SHARE_OF_LAW * after.excess.energy


def _places(stage: FitStage) -> set[tuple[str, str]]:
    """Which causes a stage has, and where."""
    return {(cause.effect.name, cause.where.label) for cause in stage.causes}


def _by_chance(comparison: Comparison, named: Sequence[Cause], seed: int) -> float:
    """What the most telling effect that is not named takes where nothing more is wrong, but in a share of CHANCE_LEVEL."""
    arm, names = comparison.linearisation.hypothesis.arm, {cause.effect.name for cause in named}
    groups = (group for group in comparison.groups if group.effect.name not in names)
    choices = [g.columns[list(w.columns)] for g in groups for w in g.effect.placements(arm)]
    gains = comparison.chance_gains(choices, np.random.default_rng(seed), _CHANCE_WORLDS)
    return float(np.quantile(gains, 1 - CHANCE_LEVEL))


def _without(fitter: CauseFitter, stage: FitStage, left_out: Collection[int], to_beat: float = np.inf) -> FitStage:
    """The fit without the causes at these places of a stage; to_beat: surplus below which it is of use."""
    rest = tuple(cause for i, cause in enumerate(stage.causes) if i not in left_out)
    return fitter.fitted(stage.comparison.linearisation, rest, to_beat)


def _without_the_least(
    fitter: CauseFitter, last: FitStage, choices: Choices, needless: Sequence[int], by_chance: float
) -> FitStage | None:
    """The fit without one of the causes that straight lines can do without, if not without all; None where there is none."""
    everything = range(len(last.causes))
    for i in sorted(needless, key=lambda i: choices.loss([k for k in everything if k != i])):
        stage = _without(fitter, last, [i])
        if _is_better(stage, last, by_chance):
            return stage
    return None


def _without_impossible(fitter: CauseFitter, stage: FitStage) -> FitStage:
    """Without causes that do surely less than nothing, if others stay: straight lines had them do a little good."""
    while 0 < len(stage.impossible) < len(stage.causes):
        stage = _without(fitter, stage, stage.impossible)
    return stage


def _without_untold(fitter: CauseFitter, stage: FitStage) -> FitStage | None:
    """The fit without causes that the recordings do not tell from nothing, if others stay; None where there is none of them.

    Beside a law whose noise is not white they may take a part of the loss all the same."""
    if not 0 < len(stage.untold) < len(stage.causes):
        return None
    without = _without(fitter, stage, stage.untold)
    return without if without.possible else None


def _without_a_needless_one(
    fitter: CauseFitter, last: FitStage, choices: Choices, least_gains: Callable[[int, float], float]
) -> FitStage | None:
    """The fit without the cause that takes least, where that leaves little more: straight lines may call it needed.

    They are not wrong by as much as all that noise makes. Half of what it must take to be added keeps it."""
    everything = range(len(last.causes))
    if len(everything) < 2:
        return None
    without = {i: choices.loss([k for k in everything if k != i]) for i in everything}
    least = min(everything, key=without.__getitem__)
    if without[least] - choices.loss(everything) > last.noise_loss:
        return None
    to_beat = last.surplus + KEPT_SHARE * least_gains(least, last.noise_loss + max(0.0, last.surplus))
    stage = _without(fitter, last, [least], to_beat)
    return stage if stage.possible and stage.surplus < to_beat else None


def _with_one_far_off(
    fitter: CauseFitter, last: FitStage, choices: Choices, offered: Sequence[Cause], by_chance: float
) -> FitStage | None:
    """The fit with one number more that lies far beyond its tolerance, where plainly more than noise is left, and much less so.

    Straight lines let it go there beside any causes, as what is known to a tolerance, and as a cause it takes no more than that
    cost. But a change as large is no straight line, and what the bend leaves may be all that is left; or all in the arm's
    equations, beside a motor whose law has another form."""
    if not leaves_plainly_more(last.excess):
        return None
    start = list(range(len(last.causes)))

    def least_gain(i: int, _: float) -> float:
        return by_chance if offered[i].effect.has_tolerance else np.inf

    farthest = best_addition(choices, start, least_gain, _simpler(last))
    if farthest is None:
        return None
    stage = fitter.fitted(last.comparison.linearisation, tuple(offered[i] for i in [*start, farthest]))
    taken, motors = last.surplus - stage.surplus, fitter.hypothesis.arm.M
    is_worth_it = taken > MIN_EXPLAINED_NEXT * last.surplus or any(
        after < (1 - MIN_EXPLAINED) * before
        for before, after in zip(last.excess.energies(motors), stage.excess.energies(motors), strict=True)
    )
    return stage if stage.possible and taken > by_chance and is_worth_it else None


def _is_better(after: FitStage, before: FitStage, by_chance: float) -> bool:
    """Whether a choice, once fitted, is better than the one before: it leaves less, or no more than noise with fewer causes.

    Laws that are new must take a part of the loss that is worth a name, or of what stands above noise: that may be few rows of one
    channel, and little of the loss."""
    if not after.possible:
        return False
    taken, known = before.surplus - after.surplus, {cause.effect.name for cause in before.causes}
    if len(after.causes) < len(before.causes):
        as_noise = not after.excess.above_noise and after.surplus < MIN_LOSS_SHARE * after.noise_loss
        kept = {cause.effect.name for cause in after.causes}
        gone = [cause.effect for cause in before.causes if cause.effect.name not in kept]
        least = by_chance
        if not any(effect.has_tolerance for effect in gone):
            least = max(least, KEPT_SHARE * MIN_EXPLAINED_NEXT * before.surplus)
        return taken > -least or as_noise
    new = [cause.effect for cause in after.causes if cause.effect.name not in known]
    if taken < MIN_LOSS_SHARE * after.noise_loss and not all(effect.has_tolerance for effect in new):
        return taken > 0 and after.excess.energy < (1 - MIN_EXPLAINED) * before.excess.energy
    return taken > 0


def _choices(stage: FitStage, comparison: Comparison, given_up: Collection[str]) -> tuple[Choices, list[Cause]]:
    """A stage's causes, by their numbers, then all others in each shape and place: as options, and as causes to be fitted.

    comparison: of the stage with every effect beside it."""
    arm = comparison.linearisation.hypothesis.arm
    offered, options = list(stage.causes), []
    amounts = [np.append(c.amounts, np.zeros(c.number_count - len(c.amounts))) / c.sizes(arm) for c in stage.causes]
    for cause, columns in zip(stage.causes, stage.columns_of_causes, strict=True):
        low = cause.effect.least_numbers(arm)[list(cause.where.columns)]
        # an option is a choice of amounts and shape: shape goes either way
        low = np.append(low, np.full(len(columns) - len(low), -np.inf))
        options.append(Option(cause.effect.name, columns, low, len(columns)))
    for group in comparison.groups:
        if group.effect.name in given_up:
            continue
        for where in group.effect.placements(arm):
            columns = group.columns[list(where.columns)]
            low = group.effect.least_numbers(arm)[list(where.columns)]
            offered.append(Cause(group.effect, where, np.zeros(len(where.columns)), dict(group.shape)))
            options.append(Option(group.effect.name, columns, low, offered[-1].number_count))
    without = comparison.with_causes_off(np.concatenate(amounts)) if amounts else comparison
    return Choices(eliminated(without), options), offered


def _least_gains(stage: FitStage, offered: Sequence[Cause], by_chance: float) -> Callable[[int, float], float]:
    """What an option must take from a loss: a part of what stands above noise, if anything does, and more than by chance.

    Else all is explained: then laws, whose forms nobody knows better, need a part of the whole, and what has a tolerance nothing
    more than to lie beyond it."""
    noise = stage.noise_loss

    def least_gain(i: int, loss: float) -> float:
        excess = loss - noise
        if stage.excess.above_noise or excess > MIN_LOSS_SHARE * noise:
            return max(by_chance, MIN_EXPLAINED_NEXT * excess)
        return by_chance if offered[i].effect.has_tolerance else max(by_chance, MIN_LOSS_SHARE * noise)

    return least_gain


def _simpler(stage: FitStage) -> Simpler:
    """One place is as good as all where it takes nearly as much, and leaves nothing that is worth a name."""
    noise = stage.noise_loss
    return Simpler(
        1 - SINGLE_PLACE_SHARE,
        lambda loss: max(MIN_LOSS_SHARE * noise, MIN_EXPLAINED_NEXT * (loss - noise)),
    )


def _with_look_alikes(fitter: CauseFitter, last: FitStage) -> tuple[tuple[NamedCause, ...], FitStage]:
    """Every cause with those that explain as much in its place; what explains most is fitted."""
    causes: list[NamedCause] = []
    beside: Comparison | None = None
    for i in range(len(last.causes)):
        if beside is None or beside.linearisation is not last.comparison.linearisation:
            beside = _with_effects(last, fitter.whiten)
        choices, offered = _choices(last, beside, ())
        count = len(last.causes)
        others = [k for k in range(count) if k != i]
        without, loss = choices.loss(others), choices.loss(range(count))
        # columns are straight lines: what is fitted may leave less, but hardly so much
        farthest = _RIVAL_REACH * tie_tolerance(last.fit.loss, without - loss) + max(0.0, last.surplus)
        near = {}
        for k in range(count, len(offered)):
            if offered[k].effect.name in {cause.effect.name for cause in last.causes}:
                continue
            left = choices.loss([*others, k])
            if left < loss + (1 - _RIVAL_SHARE) * (without - loss) and left < loss + farthest:
                effect = offered[k].effect.name
                if effect not in near or left < choices.loss([*others, near[effect]]):
                    near[effect] = k
        rivals = sorted(near.values(), key=lambda k: choices.loss([*others, k]))[: _MAX_RIVALS - 1]
        fitted, gain = [(last.causes[i], last)], without - loss
        for k in rivals:
            swapped = (*last.causes[:i], offered[k], *last.causes[i + 1 :])
            stage = fitter.fitted(last.comparison.linearisation, swapped, _most_of_a_tie(last, gain))
            if stage.possible:
                fitted.append((stage.causes[i], stage))
        kept = indistinguishable(fitted, gain)
        best, last = kept[0]
        tied = tuple(Rival(c.effect, c.where, stage.surplus) for c, stage in kept)
        causes.append(NamedCause(best.effect, best.where, tied, gain, last.fit.loss))
    return tuple(causes), last


def tie_tolerance(loss: float, gain: float) -> float:
    """Of the loss with a cause, and what the cause takes: how much more another one may leave that explains as much.

    Forms of laws are not known better than to MIN_LOSS_SHARE of what is left, nor to _SIMPLER_SHARE of what they explain."""
    return max(_TIE_BY_CHANCE, min(MIN_LOSS_SHARE * loss, _SIMPLER_SHARE * gain))


def _most_of_a_tie(best: FitStage, gain: float) -> float:
    """Surplus up to which what is fitted in the place of a cause of the best stage explains as much; gain: what the cause takes."""
    limit = best.surplus + tie_tolerance(best.fit.loss, gain)
    return limit + max(0.0, best.surplus) if best.excess.above_noise else limit


def indistinguishable(fitted: Sequence[tuple[Cause, FitStage]], gain: float) -> list[tuple[Cause, FitStage]]:
    """Those that leave little more than the best, the best first; gain: what a cause takes at this place.

    Little is `tie_tolerance`, and where the best leaves something above noise as much as that: laws have forms that nobody knows
    better. What leaves something plainly above noise where the best does not explains less. One with more numbers than another
    stays only where it leaves less by as much."""
    best = min((stage for _, stage in fitted), key=lambda stage: stage.surplus)
    limit = _most_of_a_tie(best, gain)
    kept: list[tuple[Cause, FitStage]] = []
    candidates = [
        (c, stage)
        for c, stage in fitted
        if stage.surplus <= limit and stage.excess.above_noise <= best.excess.above_noise
    ]
    for c, stage in sorted(candidates, key=lambda fitted: fitted[0].number_count):
        simpler = [s.surplus for k, s in kept if k.number_count < c.number_count]
        if not simpler or stage.surplus < min(simpler) - tie_tolerance(best.fit.loss, gain):
            kept.append((c, stage))
    return sorted(kept, key=lambda fitted: fitted[1].surplus)


def _with_effects(stage: FitStage, whiten: Whitener) -> Comparison:
    """A stage with every effect beside it in each of its shapes; those that it names only where these or their places may differ.

    Steps may not reach a shape that is far off. What only doubts the clock is no cause once one is named."""
    named, arm = {cause.effect.name for cause in stage.causes}, stage.comparison.linearisation.hypothesis.arm
    effects = [e for e in EFFECTS.values() if not (named and e.is_clock)]
    differs = {e.name for e in effects if max(len(e.start_shapes), len(e.placements(arm))) > 1}
    choices = [(e, s) for e in effects if e.name not in named or e.name in differs for s in e.start_shapes]
    at = stage.comparison.linearisation
    return compare(at, stage.causes, choices, stage.comparison.nuisances, whiten, stage.noise)


def rank(comparison: Comparison) -> list[CauseCandidate]:
    """Every effect in its best shape and place, the most telling first."""
    arm = comparison.linearisation.hypothesis.arm
    usual_folds, usual_losses, usual_prior = comparison.folds(), comparison.block_losses(), comparison.prior_loss()
    best: dict[str, CauseCandidate] = {}
    for group in comparison.groups:
        effect, options = group.effect, []
        for where in effect.placements(arm):
            columns = group.columns[list(where.columns)]
            # the first cause that is not the clock itself puts a clock in doubt which rests on the base model's laws
            relaxed = comparison.clock_relaxed or (not len(comparison.cause_columns) and not effect.is_clock)
            folds = comparison.folds(columns)
            without = usual_losses if np.array_equal(folds, usual_folds) else comparison.block_losses(folds=folds)
            options.append(
                CauseCandidate(
                    effect=effect,
                    shape=group.shape,
                    where=where,
                    columns=columns,
                    gain=float(np.sum(without - comparison.block_losses(columns, relaxed, folds)))
                    + usual_prior
                    - comparison.prior_loss(columns, relaxed),
                    number_count=len(columns) + relaxed,
                )
            )
        most = max(option.gain for option in options)
        candidate = min(
            (o for o in options if o.gain >= most - (1 - SINGLE_PLACE_SHARE) * abs(most)),
            key=lambda o: (o.number_count, -o.gain),
        )
        if effect.name not in best or candidate.gain > best[effect.name].gain:
            best[effect.name] = candidate
    clock = next((c.gain for c in best.values() if c.effect.is_clock), 0.0)
    most = max(c.gain for c in best.values())

    def gain_beyond_clock(c: CauseCandidate) -> float:
        # where doubt about the clock is all that explains, the clock itself does
        return c.gain if c.effect.is_clock or c.gain > clock + _SIMPLER_SHARE * most else c.gain - clock

    return sorted(best.values(), key=lambda c: -gain_beyond_clock(c))
