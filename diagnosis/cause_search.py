"""Which causes explain what the base model does not: the best one first, as long as one explains a part worth naming.

A cause is named where it takes MATERIAL of the loss away, or EXPLAINED of what stands plainly above noise, and more than any would
by chance. In the end those that explained about as much are fitted in its place; with it go all that leave little more: data cannot
tell these apart. Of two that explain as much the one with fewer numbers stands for both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause
from diagnosis.cause_fit import FitStage, Trial
from diagnosis.comparison import Comparison, Index, compare
from diagnosis.effect import Effect, Shape, Where
from diagnosis.effects import EFFECTS
from diagnosis.hypothesis import Hypothesis
from diagnosis.noise_ensemble import NoiseEnsemble
from identification.whitening import Whitener

Array = NDArray[np.float64]

MATERIAL = 0.08
"""of the loss: what a cause must take away at least"""
ALONE = 0.95
"""of what an effect explains everywhere: a place that explains as much has it alone"""
EXPLAINED = 0.6
"""of what stands above noise, that all causes together take away at least: else none is named"""
MOSTLY = 0.5
"""of what still stands above noise: what a further cause takes away at least"""
MOST = 3
FALSE_ALARMS = 0.01
"""how often the most telling of all causes may be told by noise and a drawing's errors alone"""
_WORLDS = 400
_RIVALS, _NEAR, _FAR = 4, 0.15, 0.7
"""so many of those that explain as much but for this part are fitted in the place of the best; more where it leaves much"""
_FORMS = 2
_SIMPLER = 0.1
"""of the gain: fewer numbers are worth as much"""


@dataclass(frozen=True)
class CauseCandidate:
    """An effect in its best shape and place, its columns, and what it takes from the loss of blocks that it was not fitted to."""

    effect: Effect
    shape: Shape
    where: Where
    columns: Index
    gains: Array
    """of every block, (B,)"""
    numbers: int
    """that it is fitted by"""

    @property
    def gain(self) -> float:
        """Of all blocks."""
        return float(self.gains.sum())


@dataclass(frozen=True)
class Rival:
    """A cause that explains as much, and the loss with it."""

    effect: Effect
    where: Where
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
    asked: Comparison
    """where it began, with every cause beside it"""
    rankings: tuple[tuple[CauseCandidate, ...], ...]
    """of every turn, the best first"""


def search(h: Hypothesis, read: Sequence[NoiseEnsemble], seed: int = 0) -> Search:
    """Causes beyond a hypothesis in recordings of one arm. Raises Refused where a motor stands still."""
    trial = Trial(h, read)
    turns, asked, found, rankings = [trial.begin()], None, [], []
    while len(found) < MOST:
        now = _all_beside(turns[-1], trial.whiten)
        asked = asked or now
        ranked = rank(now)
        rankings.append(tuple(ranked))
        step = _further(trial, turns[-1], now, ranked, np.random.default_rng(seed + len(found)))
        if step is None:
            break
        near, then = step
        found.append(near)
        turns.append(then)
    assert asked is not None
    first, last, named = turns[0], turns[-1], []
    for i, near in enumerate(found):
        kept = tied(_in_its_place(trial, turns[i], last, i, near))
        best, last = kept[0]
        named.append(NamedCause(best, tuple(Rival(c.effect, c.where, turn.loss) for c, turn in kept), turns[i].loss))
    if named and last.beyond.plain and last.beyond.energy > (1 - EXPLAINED) * first.beyond.energy:
        last, named = first, []
    whiten = trial.whiten
    if named and last.beyond.plain:
        last, whiten = trial.weighed(last)
    return Search(first, last, tuple(named), whiten, asked, tuple(rankings))


def _further(
    trial: Trial, turn: FitStage, now: Comparison, ranked: Sequence[CauseCandidate], rng: np.random.Generator
) -> tuple[list[CauseCandidate], FitStage] | None:
    """The next cause with those that explain about as much behind it, and what is left with it; None where there is none."""
    more = bool(turn.causes)
    chance = float(np.quantile(now.by_chance([c.columns for c in ranked], rng, _WORLDS), 1 - FALSE_ALARMS))
    least, plain = MATERIAL * turn.fit.loss, turn.beyond.plain
    if ranked[0].gain < chance or (not plain and (more or ranked[0].gain < least)):
        return None
    near = _near(ranked, _NEAR)
    # what a named cause leaves, for its law has another form, others may explain in part
    if more and ranked[0].gain < MOSTLY * (turn.loss - turn.quiet):
        return None

    def tried(c: CauseCandidate) -> FitStage:
        return _ended(trial, turn, turn.causes, c)

    best, then = near[0], tried(near[0])
    if then.beyond.plain:  # columns are straight lines: far from where they were drawn another may do better
        near = _near(ranked, _FAR)
        best, then = min(((c, tried(c)) for c in near), key=lambda each: _badness(each[1]))
    if not then.possible:
        return None
    # few rows of one channel may hold all that is wrong: little of the loss, but what stands above noise
    little = turn.fit.loss - then.end.with_causes_as_they_are < least
    if little and not (plain and then.beyond.energy <= (1 - EXPLAINED) * turn.beyond.energy):
        return None
    if more and then.beyond.energy > (1 - MOSTLY) * turn.beyond.energy:
        return None
    return [best, *(c for c in near if c is not best)], then


def _ended(
    trial: Trial, begun: FitStage, before: tuple[Cause, ...], c: CauseCandidate, after: tuple[Cause, ...] = ()
) -> FitStage:
    """A candidate fitted between other causes.

    A form that is far off may not be reached by steps: few enough are all begun from, of many the next where a fit went astray."""
    ends: list[FitStage] = []
    for shape in sorted(c.effect.shapes, key=lambda shape: shape != c.shape):
        ends.append(trial.settled(begun.end.point, (*before, replace(entered(c), forms=dict(shape)), *after)))
        if len(c.effect.shapes) > _FORMS and ends[-1].possible:
            break
    return min(ends, key=_badness)


def _badness(turn: FitStage) -> tuple[bool, float]:
    return not turn.possible, turn.loss


def _in_its_place(
    trial: Trial, before: FitStage, last: FitStage, i: int, near: Sequence[CauseCandidate]
) -> list[tuple[CauseCandidate, FitStage]]:
    """Cause number i, and every rival in its place, with the others that were found."""
    others = {cause.effect.name for k, cause in enumerate(last.causes) if k != i}
    out = [(near[0], last)]
    for rival in near[1:]:
        if rival.effect.name not in others:
            turn = _ended(trial, before, last.causes[:i], rival, last.causes[i + 1 :])
            if turn.possible:
                out.append((rival, turn))
    return out


def tied(tried: Sequence[tuple[CauseCandidate, "FitStage"]]) -> list[tuple[CauseCandidate, "FitStage"]]:
    """Those that leave little more than the best, the best first.

    Little is MATERIAL of what is left, and where the best leaves something above noise as much as that: laws have forms that
    nobody knows better. What leaves something plainly above noise where the best does not explains less. One with more numbers than
    another stays only where it leaves less by as much."""
    best = min((turn for _, turn in tried), key=lambda turn: turn.loss)
    most = (1 + MATERIAL) * best.loss + (max(0.0, best.loss - best.quiet) if best.beyond.plain else 0.0)
    kept: list[tuple[CauseCandidate, FitStage]] = []
    near = [each for each in tried if each[1].loss <= most and each[1].beyond.plain <= best.beyond.plain]
    for c, turn in sorted(near, key=lambda each: each[0].numbers):
        simpler = [t.loss for k, t in kept if k.numbers < c.numbers]
        if not simpler or turn.loss < (1 - MATERIAL) * min(simpler):
            kept.append((c, turn))
    return sorted(kept, key=lambda each: each[1].loss)


def _near(ranked: Sequence[CauseCandidate], part: float) -> list[CauseCandidate]:
    """Those that explain as much as the best but for this part, at most _RIVALS, what does with fewer numbers first."""
    near = [c for c in ranked if c.gain >= (1 - part) * ranked[0].gain][:_RIVALS]
    return sorted(near, key=lambda c: (c.gain < (1 - _SIMPLER) * ranked[0].gain, c.numbers, -c.gain))


def _all_beside(turn: FitStage, whiten: Whitener) -> Comparison:
    """Every cause that is not named yet, in each of its shapes. What only doubts the clock is no cause once one is named."""
    taken = {cause.effect.name for cause in turn.causes}
    left = [e for e in EFFECTS.values() if e.name not in taken and not (taken and e.of_clock)]
    every = [(e, shape) for e in left for shape in e.shapes]
    return compare(turn.end.point, turn.causes, every, turn.end.known, whiten, turn.floor)


def rank(now: Comparison) -> list[CauseCandidate]:
    """Every effect in its best shape and place, the most telling first."""
    arm = now.point.hypothesis.arm
    usual, base = now.dealt(), now.crossed()
    best: dict[str, CauseCandidate] = {}
    for group in now.groups:
        effect, options = group.effect, []
        for where in effect.wheres(arm):
            columns = group.columns[list(where.columns)]
            # the first cause that is not the clock itself puts a clock in doubt which rests on the base model's laws
            doubted = now.doubted or (not len(now.held) and not effect.of_clock)
            dealt = now.dealt(columns)
            plain = base if np.array_equal(dealt, usual) else now.crossed(dealt=dealt)
            gains = plain - now.crossed(columns, doubted, dealt)
            options.append(CauseCandidate(effect, group.shape, where, columns, gains, len(columns) + doubted))
        most = max(option.gain for option in options)
        found = min(
            (o for o in options if o.gain >= most - (1 - ALONE) * abs(most)),
            key=lambda o: (o.numbers, -o.gain),
        )
        if effect.name not in best or found.gain > best[effect.name].gain:
            best[effect.name] = found
    clock = next((c.gain for c in best.values() if c.effect.of_clock), 0.0)
    most = max(c.gain for c in best.values())
    # where doubt about the clock is all that explains, the clock itself does
    return sorted(
        best.values(),
        key=lambda c: -(c.gain if c.effect.of_clock or c.gain > clock + _SIMPLER * most else c.gain - clock),
    )


def entered(c: CauseCandidate) -> Cause:
    """A candidate as a cause that does nothing yet."""
    return Cause(c.effect, c.where, np.zeros(len(c.where.columns)), dict(c.shape))
