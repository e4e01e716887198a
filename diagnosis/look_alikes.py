"""Causes with those that explain as much in their place: data cannot tell these apart.

Of two that explain as much the one with fewer numbers stands for both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diagnosis.cause import Cause
from diagnosis.cause_fit import CauseFitter
from diagnosis.comparison import Comparison
from diagnosis.effect import Effect, Placement
from diagnosis.fit_stage import FitStage
from diagnosis.offered_causes import choices_beside, with_effects
from diagnosis.worth_naming import tie_tolerance

_MAX_RIVALS = 4
"""causes that are fitted in the place of the best one, itself among them (docs/thresholds.md)"""
_RIVAL_SHARE = 0.7
"""of what a cause takes: what another one must take in its place to be fitted there (docs/thresholds.md)"""
_RIVAL_REACH = 3.0
"""times what causes may differ by that explain alike: how much more another one leaves at most that is fitted in its place
(docs/thresholds.md)"""


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


def with_look_alikes(fitter: CauseFitter, last: FitStage) -> tuple[tuple[NamedCause, ...], FitStage]:
    """Every cause with those that explain as much in its place; what explains most is fitted."""
    causes: list[NamedCause] = []
    beside: Comparison | None = None
    for i in range(len(last.causes)):
        if beside is None or beside.linearisation is not last.comparison.linearisation:
            beside = with_effects(last, fitter.whiten)
        choices, offered = choices_beside(last, beside, ())
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
