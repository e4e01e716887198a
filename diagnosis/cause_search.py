"""Which causes explain what the base model does not: the best one first, as long as one explains a part worth naming.

A cause is named where it takes MIN_LOSS_SHARE of the loss away, or MIN_EXPLAINED of what stands plainly above noise, and more than
any would by chance. In the end those that explained about as much are fitted in its place; with it go all that leave little more:
data cannot tell these apart. Of two that explain as much the one with fewer numbers stands for both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause
from diagnosis.cause_fit import CauseFitter, FitStage
from diagnosis.comparison import Comparison, Index, compare
from diagnosis.effect import Effect, Placement, Shape
from diagnosis.effects import EFFECTS
from diagnosis.hypothesis import Hypothesis
from diagnosis.noise_ensemble import NoiseEnsemble
from identification.whitening import Whitener

Array = NDArray[np.float64]

MIN_LOSS_SHARE = 0.08
"""of the loss: what a cause must take away at least (docs/thresholds.md)"""
SINGLE_PLACE_SHARE = 0.95
"""of what an effect explains everywhere: a place that explains as much has it alone (docs/thresholds.md)"""
MIN_EXPLAINED = 0.6
"""of what stands above noise: what all causes together take away at least, else none is named (docs/thresholds.md)"""
MIN_EXPLAINED_NEXT = 0.5
"""of what still stands above noise: what a further cause takes away at least (docs/thresholds.md)"""
MAX_CAUSES = 3
"""causes that are named at most (docs/thresholds.md)"""
CHANCE_LEVEL = 0.01
"""share of worlds of noise and a drawing's errors alone in which the most telling of all causes may seem to explain as much
(docs/thresholds.md)"""
_CHANCE_WORLDS = 400
_MAX_RIVALS = 4
"""causes that are fitted in the place of the best one, itself among them (docs/thresholds.md)"""
_RIVAL_SHORTFALL, _RIVAL_SHORTFALL_FAR = 0.15, 0.7
"""of the best one's gain: how much less a rival explains at most; and where the best leaves something above noise
(docs/thresholds.md)"""
_ALL_SHAPES = 2
"""start shapes up to which a fit is begun from every one; of more, from the next where one went astray (docs/thresholds.md)"""
_SIMPLER_SHARE = 0.1
"""of the gain: by so much less, fewer numbers are worth as much (docs/thresholds.md)"""


@dataclass(frozen=True)
class CauseCandidate:
    """An effect in its best shape and place, its columns, and what it takes from the loss of blocks that it was not fitted to."""

    effect: Effect
    shape: Shape
    where: Placement
    columns: Index
    block_gains: Array
    """of every block, (B,)"""
    number_count: int
    """of numbers that it is fitted by"""

    @property
    def gain(self) -> float:
        """Of all blocks."""
        return float(self.block_gains.sum())


@dataclass(frozen=True)
class Rival:
    """A cause that explains as much, and the loss with it."""

    effect: Effect
    where: Placement
    loss: float


@dataclass(frozen=True)
class NamedCause:
    """A cause, those that explain as much with itself as the first, and the loss before it."""

    best: CauseCandidate
    tied: tuple[Rival, ...]
    loss_before: float


@dataclass(frozen=True)
class Search:
    """Where it began, where it ended, and what was named on the way."""

    first: FitStage
    last: FitStage
    named: tuple[NamedCause, ...]
    whiten: Whitener
    every_effect: Comparison
    """the first stage with all effects beside it"""
    rankings: tuple[tuple[CauseCandidate, ...], ...]
    """of every stage, the best first"""


def search_causes(h: Hypothesis, ensembles: Sequence[NoiseEnsemble], seed: int = 0) -> Search:
    """Causes beyond a hypothesis in recordings of one arm. Raises Refused where a motor stands still."""
    fitter = CauseFitter(h, ensembles)
    stages, every_effect = [fitter.base_model()], None
    rival_sets: list[list[CauseCandidate]] = []
    rankings: list[tuple[CauseCandidate, ...]] = []
    while len(rival_sets) < MAX_CAUSES:
        comparison = _with_effects(stages[-1], fitter.whiten)
        every_effect = every_effect or comparison
        ranked = rank(comparison)
        rankings.append(tuple(ranked))
        rng = np.random.default_rng(seed + len(rival_sets))
        named = _next_cause(fitter, stages[-1], comparison, ranked, rng)
        if named is None:
            break
        rivals, stage = named
        rival_sets.append(rivals)
        stages.append(stage)
    assert every_effect is not None
    first, last, causes = stages[0], stages[-1], []
    for i, rivals in enumerate(rival_sets):
        kept = indistinguishable(_fitted_in_its_place(fitter, stages[i], last, i, rivals))
        best, last = kept[0]
        tied = tuple(Rival(c.effect, c.where, stage.loss) for c, stage in kept)
        causes.append(NamedCause(best, tied, stages[i].loss))
    if causes and last.excess.above_noise and last.excess.energy > (1 - MIN_EXPLAINED) * first.excess.energy:
        last, causes = first, []
    whiten = fitter.whiten
    if causes and last.excess.above_noise:
        last, whiten = fitter.reweighted(last)
    return Search(
        first=first,
        last=last,
        named=tuple(causes),
        whiten=whiten,
        every_effect=every_effect,
        rankings=tuple(rankings),
    )


def _next_cause(
    fitter: CauseFitter,
    stage: FitStage,
    comparison: Comparison,
    ranked: Sequence[CauseCandidate],
    rng: np.random.Generator,
) -> tuple[list[CauseCandidate], FitStage] | None:
    """The next cause with those that explain about as much behind it, and the stage with it; None where there is none."""
    is_further, above_noise = bool(stage.causes), stage.excess.above_noise
    chance_gains = comparison.chance_gains([c.columns for c in ranked], rng, _CHANCE_WORLDS)
    by_chance = float(np.quantile(chance_gains, 1 - CHANCE_LEVEL))
    min_gain = MIN_LOSS_SHARE * stage.fit.loss
    if ranked[0].gain < by_chance or (not above_noise and (is_further or ranked[0].gain < min_gain)):
        return None
    rivals = _rivals(ranked, _RIVAL_SHORTFALL)
    # what a named cause leaves, for its law has another form, others may explain in part
    if is_further and ranked[0].gain < MIN_EXPLAINED_NEXT * (stage.loss - stage.noise_loss):
        return None

    def with_candidate(c: CauseCandidate) -> FitStage:
        return _fitted_among(fitter, stage, stage.causes, c)

    best, after = rivals[0], with_candidate(rivals[0])
    if after.excess.above_noise:  # columns are straight lines: far from where they were drawn another may do better
        rivals = _rivals(ranked, _RIVAL_SHORTFALL_FAR)
        best, after = min(((c, with_candidate(c)) for c in rivals), key=lambda fitted: _badness(fitted[1]))
    if not after.possible:
        return None
    # few rows of one channel may hold all that is wrong: little of the loss, but what stands above noise
    is_small = stage.fit.loss - after.comparison.loss_with_fixed_causes < min_gain
    if is_small and not (above_noise and after.excess.energy <= (1 - MIN_EXPLAINED) * stage.excess.energy):
        return None
    if is_further and after.excess.energy > (1 - MIN_EXPLAINED_NEXT) * stage.excess.energy:
        return None
    return [best, *(c for c in rivals if c is not best)], after


def _fitted_among(
    fitter: CauseFitter,
    start: FitStage,
    before: tuple[Cause, ...],
    candidate: CauseCandidate,
    behind: tuple[Cause, ...] = (),
) -> FitStage:
    """A candidate fitted between other causes.

    A shape that is far off may not be reached by steps: up to _ALL_SHAPES are all begun from, of more the next one where a fit
    ended with an impossible amount."""
    stages: list[FitStage] = []
    for shape in sorted(candidate.effect.start_shapes, key=lambda shape: shape != candidate.shape):
        cause = replace(as_inactive_cause(candidate), shape=dict(shape))
        stages.append(fitter.fitted(start.comparison.linearisation, (*before, cause, *behind)))
        if len(candidate.effect.start_shapes) > _ALL_SHAPES and stages[-1].possible:
            break
    return min(stages, key=_badness)


def _badness(stage: FitStage) -> tuple[bool, float]:
    return not stage.possible, stage.loss


def _fitted_in_its_place(
    fitter: CauseFitter, before: FitStage, last: FitStage, i: int, rivals: Sequence[CauseCandidate]
) -> list[tuple[CauseCandidate, FitStage]]:
    """Cause number i, and every rival in its place, with the other causes that were named."""
    others = {cause.effect.name for k, cause in enumerate(last.causes) if k != i}
    out = [(rivals[0], last)]
    for rival in rivals[1:]:
        if rival.effect.name not in others:
            stage = _fitted_among(fitter, before, last.causes[:i], rival, last.causes[i + 1 :])
            if stage.possible:
                out.append((rival, stage))
    return out


def indistinguishable(fitted: Sequence[tuple[CauseCandidate, FitStage]]) -> list[tuple[CauseCandidate, FitStage]]:
    """Those that leave little more than the best, the best first.

    Little is MIN_LOSS_SHARE of what is left, and where the best leaves something above noise as much as that: laws have forms that
    nobody knows better. What leaves something plainly above noise where the best does not explains less. One with more numbers than
    another stays only where it leaves less by as much."""
    best = min((stage for _, stage in fitted), key=lambda stage: stage.loss)
    limit = (1 + MIN_LOSS_SHARE) * best.loss
    if best.excess.above_noise:
        limit += max(0.0, best.loss - best.noise_loss)
    kept: list[tuple[CauseCandidate, FitStage]] = []
    candidates = [
        (c, stage) for c, stage in fitted if stage.loss <= limit and stage.excess.above_noise <= best.excess.above_noise
    ]
    for c, stage in sorted(candidates, key=lambda fitted: fitted[0].number_count):
        simpler = [s.loss for k, s in kept if k.number_count < c.number_count]
        if not simpler or stage.loss < (1 - MIN_LOSS_SHARE) * min(simpler):
            kept.append((c, stage))
    return sorted(kept, key=lambda fitted: fitted[1].loss)


def _rivals(ranked: Sequence[CauseCandidate], shortfall: float) -> list[CauseCandidate]:
    """Those that explain as much as the best but for this share, at most _MAX_RIVALS, what does with fewer numbers first."""
    close = [c for c in ranked if c.gain >= (1 - shortfall) * ranked[0].gain][:_MAX_RIVALS]
    return sorted(close, key=lambda c: (c.gain < (1 - _SIMPLER_SHARE) * ranked[0].gain, c.number_count, -c.gain))


def _with_effects(stage: FitStage, whiten: Whitener) -> Comparison:
    """A stage with every effect that is not named yet beside it, in each of its shapes.

    What only doubts the clock is no cause once one is named."""
    named = {cause.effect.name for cause in stage.causes}
    effects = [e for e in EFFECTS.values() if e.name not in named and not (named and e.is_clock)]
    choices = [(e, shape) for e in effects for shape in e.start_shapes]
    at = stage.comparison.linearisation
    return compare(at, stage.causes, choices, stage.comparison.nuisances, whiten, stage.noise)


def rank(comparison: Comparison) -> list[CauseCandidate]:
    """Every effect in its best shape and place, the most telling first."""
    arm = comparison.linearisation.hypothesis.arm
    usual_folds, usual_losses = comparison.folds(), comparison.block_losses()
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
                    block_gains=without - comparison.block_losses(columns, relaxed, folds),
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


def as_inactive_cause(c: CauseCandidate) -> Cause:
    """A candidate as a cause that does nothing yet."""
    return Cause(c.effect, c.where, np.zeros(len(c.where.columns)), dict(c.shape))
