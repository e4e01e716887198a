"""Causes chosen jointly by straight lines, fitted together, and chosen anew where they then are.

Each takes a part worth naming of what stands above noise, and more than any would by chance. What is known to a tolerance is a
cause where it lies further beyond than chance puts any. A cause that the others make needless is given up.
"""

from collections.abc import Callable, Sequence

import numpy as np

from diagnosis.cause import Cause
from diagnosis.cause_fit import CauseFitter, fitted_without
from diagnosis.comparison import Comparison
from diagnosis.fit_stage import FitStage
from diagnosis.free_function import FreeFits
from diagnosis.offered_causes import choices_beside, with_effects
from diagnosis.remainder import leaves_plainly_more
from diagnosis.stepwise import Choices, Simpler, best_addition, chosen_jointly
from diagnosis.worth_naming import MIN_EXPLAINED, MIN_EXPLAINED_NEXT, MIN_LOSS_SHARE, SINGLE_PLACE_SHARE
from identification.whitening import Whitener

MAX_SHARE_OF_LAW = 0.25
"""of what a further cause leaves: a function of one variable that leaves less in its place ends the choice (docs/thresholds.md)"""
KEPT_SHARE = 0.5
"""of what a cause must take to be added: what takes less beside causes that came after it is needless (docs/thresholds.md)"""
ANEW_SHARE = 0.5
"""of what was left: where causes leave less all others are offered anew (docs/thresholds.md)"""
CHANCE_LEVEL = 0.01
"""share of worlds of noise and a drawing's errors alone in which the most telling of all causes may seem to explain as much
(docs/thresholds.md)"""
_CHANCE_WORLDS = 400
_MAX_AT_ONCE = 4
"""causes that are added at once; where straight lines would have more, the best one comes first (docs/thresholds.md)"""
_MAX_CHOICES = 12
"""of causes, each fitted before the next"""


def with_all_causes(
    fitter: CauseFitter, first: FitStage, every_effect: Comparison, free_fits: FreeFits, seed: int
) -> tuple[CauseFitter, FitStage]:
    """Causes chosen jointly, fitted together, and chosen anew where they then are, until the choice stands.

    first: where the choice begins; every_effect: it with all effects beside it.
    A wrong model's noise is another one: weights are told anew where that of a better one is. What was given up beside other
    causes is offered once more before the choice stands: what they did not explain may have driven it where nothing can be. Where a
    law would do better than causes that leave far less, the end of the choice says whether they only stood in for it."""
    last, given_up, beside = first, dict[str, FitStage](), every_effect
    doubted: list[tuple[CauseFitter, FitStage]] = []
    been = [_places(first)]
    for _ in range(_MAX_CHOICES):
        by_chance = _by_chance(beside, last.causes, seed)
        choices, offered = choices_beside(last, beside, given_up)
        start, least_gains = list(range(len(last.causes))), _least_gains(last, offered, by_chance)
        simpler = _simpler(last)
        chosen = chosen_jointly(choices, start, least_gains, simpler)
        if sorted(chosen) == start:
            after = _without_a_needless_one(fitter, last, choices, least_gains, by_chance)
            after = after or _with_one_far_off(fitter, last, choices, offered, by_chance)
            after = after or _in_all_places(fitter, last, by_chance)
        else:
            added = [i for i in chosen if i not in start]
            alone = best_addition(choices, start, least_gains, simpler) if len(added) > 1 else None
            if alone is not None and len(added) > _MAX_AT_ONCE:
                # so many stand in for the bend of one, and take minutes to fit
                chosen, added, alone = [*start, alone], [alone], None
            joint = fitter.fitted(last.comparison.linearisation, tuple(offered[i] for i in sorted(chosen)))
            after = _without_impossible(fitter, joint)
            fitted = {cause.effect.name for cause in after.causes}
            given_up |= {offered[i].effect.name: last for i in added if offered[i].effect.name not in fitted}
            misled = not _is_better(after, last, by_chance)
            misled = misled or (not _halves(last, after) and _a_law_would_do(last, after, fitter.whiten, free_fits))
            if alone is not None and (misled or after is not joint):
                # where straight lines mislead, one cause may, and take a right one with it
                only = fitter.fitted(last.comparison.linearisation, tuple(offered[i] for i in [*start, alone]))
                if misled or (only.possible and only.surplus < after.surplus):
                    after = only
            # the same causes, by another way or from another shape
            no_other = _places(after) == _places(last) and last.surplus - after.surplus < by_chance
            if no_other or not _is_better(after, last, by_chance):
                if added:
                    # of several the best one may have taken the others with it: these are offered again without it
                    given_up |= {offered[i].effect.name: last for i in (added if alone is None else [alone])}
                    continue
                after = _without_the_least(fitter, last, choices, [i for i in start if i not in chosen], by_chance)
        if after is None:
            here = {name: stage for name, stage in given_up.items() if stage is last}
            if len(here) == len(given_up) or not last.excess.above_noise:
                break
            given_up = here
            continue
        if _places(after) in been and _places(after) != _places(last):
            # one cause more, one fewer, and so on: what is left is about the same, but for what stands plainly above noise
            if _clears(after, last, by_chance):
                fitter, last = fitter.with_own_weights(after)
            break
        if _a_law_would_do(last, after, fitter.whiten, free_fits):
            if _halves(last, after):
                doubted.append((fitter, last))
            else:
                # beside a number that is far off no cause explains what it would
                after = _with_one_far_off(fitter, last, choices, offered, by_chance)
                if after is None:
                    break
        if _halves(last, after):
            given_up = {}  # what was given up beside so much more may be right now
        fitter, last = fitter.with_own_weights(after)
        been.append(_places(last))
        beside = with_effects(last, fitter.whiten)
    for fitter_before, before in doubted:
        if _a_law_would_do(before, last, fitter_before.whiten, free_fits):
            return fitter_before, before
    return fitter, last


def share_that_causes_leave(stage: FitStage, whiten: Whitener, seed: int) -> float:
    """Of a stage's surplus, the part that straight lines leave with all that they would have beside its causes."""
    beside = with_effects(stage, whiten)
    choices, offered = choices_beside(stage, beside, ())
    start = list(range(len(stage.causes)))
    chosen = chosen_jointly(
        choices, start, _least_gains(stage, offered, _by_chance(beside, stage.causes, seed)), _simpler(stage)
    )
    return 1 - (choices.loss(start) - choices.loss(chosen)) / max(stage.surplus, 1.0)


def _halves(last: FitStage, after: FitStage) -> bool:
    """Whether causes leave so much less that a law that would do better still does not end the choice."""
    return after.surplus < ANEW_SHARE * last.surplus


def _a_law_would_do(last: FitStage, after: FitStage, whiten: Whitener, free_fits: FreeFits) -> bool:
    """Whether causes that come to others leave far more than a law that nobody listed would: they only stand in for it."""
    if not len(after.causes) > len(last.causes) > 0 or not leaves_plainly_more(after.excess):
        return False
    unlisted = free_fits.best(last, whiten)
    return unlisted is not None and unlisted.excess.share_of(after.excess) < MAX_SHARE_OF_LAW


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


def _without_the_least(
    fitter: CauseFitter, last: FitStage, choices: Choices, needless: Sequence[int], by_chance: float
) -> FitStage | None:
    """The fit without one of the causes that straight lines can do without, if not without all; None where there is none."""
    everything = range(len(last.causes))
    for i in sorted(needless, key=lambda i: choices.loss([k for k in everything if k != i])):
        stage = fitted_without(fitter, last, [i])
        if _is_better(stage, last, by_chance):
            return stage
    return None


def _without_impossible(fitter: CauseFitter, stage: FitStage) -> FitStage:
    """Without causes that do surely less than nothing, if others stay: straight lines had them do a little good."""
    while 0 < len(stage.impossible) < len(stage.causes):
        stage = fitted_without(fitter, stage, stage.impossible)
    return stage


def _without_a_needless_one(
    fitter: CauseFitter,
    last: FitStage,
    choices: Choices,
    least_gains: Callable[[int, float], float],
    by_chance: float,
) -> FitStage | None:
    """The fit without the cause that takes least, where that leaves little more: straight lines may call it needed.

    They are not wrong by as much as all that noise makes. Half of what it must take to be added keeps it, and so does an equation
    that is left with plainly more than noise without it alone."""
    everything = range(len(last.causes))
    if len(everything) < 2:
        return None
    without = {i: choices.loss([k for k in everything if k != i]) for i in everything}
    least = min(everything, key=without.__getitem__)
    if without[least] - choices.loss(everything) > last.noise_loss:
        return None
    to_beat = last.surplus + KEPT_SHARE * least_gains(least, last.noise_loss + max(0.0, last.surplus))
    stage = fitted_without(fitter, last, [least], to_beat)
    is_needless = stage.surplus < to_beat and not _clears(last, stage, by_chance)
    return stage if stage.possible and is_needless else None


def _clears(stage: FitStage, other: FitStage, by_chance: float) -> bool:
    """Whether nothing stands plainly above noise any more, and did beside what another stage has, by more than chance makes."""
    is_clear = leaves_plainly_more(other.excess) and not leaves_plainly_more(stage.excess)
    return is_clear and other.surplus - stage.surplus > by_chance


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
        stage.excess.share_of(last.excess, channels) < 1 - MIN_EXPLAINED
        for channels in (slice(0, motors), slice(motors, None))
    )
    return stage if stage.possible and taken > by_chance and is_worth_it else None


def _in_all_places(fitter: CauseFitter, last: FitStage, by_chance: float) -> FitStage | None:
    """The fit with a cause that is there in full or not at all in all its places, where much less is left than with it in one.

    What turns over all at once is nothing to straight lines where the fit does not come to it."""
    if not leaves_plainly_more(last.excess):
        return None
    for i, cause in enumerate(last.causes):
        everywhere, *single = cause.effect.placements(last.comparison.linearisation.hypothesis.arm)
        if not cause.effect.in_full or cause.where not in single:
            continue
        for shape in cause.effect.start_shapes:
            wide = Cause(cause.effect, everywhere, np.zeros(len(everywhere.columns)), shape)
            stage = fitter.fitted(
                last.comparison.linearisation, (*last.causes[:i], wide, *last.causes[i + 1 :]), last.surplus
            )
            taken = last.surplus - stage.surplus
            if stage.possible and taken > max(by_chance, MIN_EXPLAINED_NEXT * last.surplus):
                return stage
    return None


def _is_better(after: FitStage, before: FitStage, by_chance: float) -> bool:
    """Whether a choice, once fitted, is better than the one before: it leaves less, or no more than noise with fewer causes.

    What is known to a tolerance goes far beyond it by straight lines, but not in what is left: that must not grow by much.
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
        leaves_more = leaves_plainly_more(after.excess) and after.excess.share_of(before.excess) > 1 / ANEW_SHARE
        return (taken > -least and not leaves_more) or as_noise
    new = [cause.effect for cause in after.causes if cause.effect.name not in known]
    if taken < MIN_LOSS_SHARE * after.noise_loss and not all(effect.has_tolerance for effect in new):
        return taken > 0 and after.excess.share_of(before.excess) < 1 - MIN_EXPLAINED
    return taken > 0


def _least_gains(stage: FitStage, offered: Sequence[Cause], by_chance: float) -> Callable[[int, float], float]:
    """What an option must take from a loss: a part of what stands above noise, if anything does, and more than by chance.

    Else all is explained: then laws, whose forms nobody knows better, need a part of the whole, or of a loss that is more than
    that; and what has a tolerance nothing more than to lie beyond it, in noise as loud as that loss."""
    noise = stage.noise_loss

    def least_gain(i: int, loss: float) -> float:
        excess = loss - noise
        if not stage.excess.above_noise and offered[i].effect.has_tolerance:
            return by_chance * max(1.0, loss / noise)
        if stage.excess.above_noise or excess > MIN_LOSS_SHARE * noise:
            return max(by_chance, MIN_EXPLAINED_NEXT * excess)
        return max(by_chance, MIN_LOSS_SHARE * noise)

    return least_gain


def _simpler(stage: FitStage) -> Simpler:
    """One place is as good as all where it takes nearly as much, and leaves nothing that is worth a name."""
    noise = stage.noise_loss
    return Simpler(
        1 - SINGLE_PLACE_SHARE,
        lambda loss: max(MIN_LOSS_SHARE * noise, MIN_EXPLAINED_NEXT * (loss - noise)),
    )
