"""Which causes explain what the base model does not: the best one first, as long as one explains a part worth naming.

A cause is named where it takes MATERIAL of the loss away, and more than any would by chance. In the end those that explained
about as much are fitted in its place; with it go all that leave little more: data cannot tell these apart. Of two that
explain as much the one with fewer numbers stands for both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identification.dataset import DataSet
from identification.diagnosis.cause import Cause, believed
from identification.diagnosis.comparison import Comparison, Fitted, Index, compare
from identification.diagnosis.effect import Effect, Shape, Where
from identification.diagnosis.effects import EFFECTS
from identification.diagnosis.excess import Excess, excess
from identification.diagnosis.hypothesis import Hypothesis
from identification.diagnosis.noise import Read, noise, quiet, whitener
from identification.diagnosis.nuisances import errors
from identification.diagnosis.point import Point, point, read_all, relaid, sought
from identification.estimates import check_motion
from identification.fitting import solve, stretch_starts
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
_SIMPLER = 0.1
"""of the gain: fewer numbers are worth as much"""
_ROUNDS = 16
_FAR_M, _SOFT = 5e-3, 0.3
"""x0 beyond the description's, and stiffness over the middle one: a fit begins within"""
_SETTLED, _GAINED = 0.3, 1e-3
"""where a step would take less away, in units of a row's loss, it is not taken; where it took less of the loss it was the last"""
_FIRST_DAMPING, _MOST_DAMPING = 1e-2, 0.5


@dataclass(frozen=True)
class Candidate:
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
class Turn:
    """Recordings with the causes named so far."""

    end: Comparison
    causes: tuple[Cause, ...]
    """with numbers"""
    floor: tuple[list[Array], ...]
    """residuals of noise alone, by recording and draw"""
    quiet: float
    """loss that noise alone makes"""
    fit: Fitted

    @cached_property
    def sigma(self) -> Array:
        """Of all numbers of the fit, in their sizes, (K,)."""
        return np.sqrt(np.diag(self.end.covariance(self.fit)))

    @cached_property
    def loss(self) -> float:
        """Of blocks where all but their fold were fitted."""
        return float(self.end.crossed().sum())

    @cached_property
    def beyond(self) -> Excess:
        """What stands above noise."""
        return self.without(self.fit)

    def without(self, fit: Fitted, end: "Comparison | None" = None) -> Excess:
        """The same with another fit, of another comparison at this point."""
        trust = [place.trust for place in self.end.point.places]
        left = [t * r for t, r in zip(trust, (end or self.end).left(fit), strict=True)]
        return excess(left, [[t * d for d in draws] for t, draws in zip(trust, self.floor, strict=True)])


@dataclass(frozen=True)
class Rival:
    """A cause that explains as much, and the loss with it."""

    effect: Effect
    where: Where
    loss: float


@dataclass(frozen=True)
class Named:
    """A cause, those that explain as much with itself as the first, and the loss before it."""

    best: Candidate
    tied: tuple[Rival, ...]
    loss_before: float


@dataclass(frozen=True)
class Search:
    """Where it began, where it ended, and what was named on the way."""

    first: Turn
    last: Turn
    named: tuple[Named, ...]
    whiten: Whitener
    asked: Comparison
    """where it began, with every cause beside it"""
    rankings: tuple[tuple[Candidate, ...], ...]
    """of every turn, the best first"""


def search(h: Hypothesis, read: Sequence[Read], seed: int = 0) -> Search:
    """Causes beyond a hypothesis in recordings of one arm. Raises Refused where a motor stands still."""
    data = [one.data for one in read]
    at = _begun(h, data)
    whiten = whitener(noise(at, read), [stretch_starts(place.signals) for place in at.places], h.arm.M)

    known: dict[tuple[tuple[str, str], ...], Turn] = {}

    def settled(at: Point, causes: tuple[Cause, ...]) -> Turn:
        """Fitted with these causes, and what stands above noise there."""
        which = tuple((cause.effect.name, cause.where.label) for cause in causes)
        if which not in known:
            known[which] = fitted(at, causes)
        return known[which]

    def fitted(at: Point, causes: tuple[Cause, ...]) -> Turn:
        end, causes = refined(at, h, causes, data, whiten)
        floor = noise(end.point, read)
        return Turn(end, causes, tuple(floor), quiet(floor, end.point, whiten), end.fit())

    turns = [settled(at, ())]
    asked = now = _all_beside(turns[0], whiten)
    found: list[tuple[Candidate, ...]] = []
    rankings: list[tuple[Candidate, ...]] = []
    while len(found) < MOST:
        turn, rng = turns[-1], np.random.default_rng(seed + len(found))
        ranked = rank(now)
        rankings.append(tuple(ranked))
        chance = float(np.quantile(now.by_chance([c.columns for c in ranked], rng, _WORLDS), 1 - FALSE_ALARMS))
        if ranked[0].gain < max(MATERIAL * turn.fit.loss, chance) or (found and not turn.beyond.plain):
            break
        near = _near(ranked, _NEAR)
        if found and not _mostly(now, near[0], turn):
            break
        best, then = near[0], settled(turn.end.point, (*turn.causes, entered(near[0])))
        if then.beyond.plain:  # columns are straight lines: far from where they were drawn another may do better
            near = _near(ranked, _FAR)
            tried = [(best, then)]
            tried += [(c, settled(turn.end.point, (*turn.causes, entered(c)))) for c in near if c is not best]
            best, then = min(tried, key=lambda each: each[1].loss)
        if then.end.with_causes_as_they_are > (1 - MATERIAL) * turn.fit.loss:
            break
        if found and then.beyond.energy > (1 - MOSTLY) * turn.beyond.energy:
            break
        found.append((best, *(c for c in near if c is not best)))
        turns.append(then)
        now = _all_beside(then, whiten)
    first, last, named = turns[0], turns[-1], []
    for i, near in enumerate(found):
        # every rival in the place of the cause, with the others that were found
        tried = [(near[0], last)]
        for rival in near[1:]:
            causes = (*last.causes[:i], entered(rival), *last.causes[i + 1 :])
            tried.append((rival, settled(turns[i].end.point, causes)))
        kept = tied(tried)
        best, last = kept[0]
        named.append(Named(best, tuple(Rival(c.effect, c.where, turn.loss) for c, turn in kept), turns[i].loss))
    if named and last.beyond.plain and last.beyond.energy > (1 - EXPLAINED) * first.beyond.energy:
        last, named = first, []
    return Search(first, last, tuple(named), whiten, asked, tuple(rankings))


def tied(tried: Sequence[tuple[Candidate, "Turn"]]) -> list[tuple[Candidate, "Turn"]]:
    """Those that leave little more than the best, the best first.

    Little is MATERIAL of what is left, and where the best leaves something above noise as much as that: laws have forms that
    nobody knows better. One with more numbers than another stays only where it leaves less by as much."""
    best = min((turn for _, turn in tried), key=lambda turn: turn.loss)
    most = (1 + MATERIAL) * best.loss + (max(0.0, best.loss - best.quiet) if best.beyond.plain else 0.0)
    kept: list[tuple[Candidate, Turn]] = []
    for c, turn in sorted((each for each in tried if each[1].loss <= most), key=lambda each: each[0].numbers):
        simpler = [t.loss for k, t in kept if k.numbers < c.numbers]
        if not simpler or turn.loss < (1 - MATERIAL) * min(simpler):
            kept.append((c, turn))
    return sorted(kept, key=lambda each: each[1].loss)


def _mostly(now: Comparison, c: Candidate, turn: Turn) -> bool:
    """Whether a further cause could take most of what is still above noise: what a named one leaves, for its law has another
    form, others may explain in part."""
    return turn.without(now.fit(c.columns), now).energy <= (1 - MOSTLY) * turn.beyond.energy


def _near(ranked: Sequence[Candidate], part: float) -> list[Candidate]:
    """Those that explain as much as the best but for this part, at most _RIVALS, what does with fewer numbers first."""
    near = [c for c in ranked if c.gain >= (1 - part) * ranked[0].gain][:_RIVALS]
    return sorted(near, key=lambda c: (c.gain < (1 - _SIMPLER) * ranked[0].gain, c.numbers, -c.gain))


def _begun(h: Hypothesis, data: Sequence[DataSet]) -> Point:
    """The base model's numbers by least squares, kept from where a cause that is not in it may have driven them."""
    late = np.zeros(len(data))
    signals = read_all(h, data, late)
    check_motion(signals)
    u = sought(h, len(data))
    p = solve(signals, u).least_squares.copy()
    for recording in range(len(data)):
        slot = u.slots["x0", recording]
        p[slot] = np.clip(p[slot], -_FAR_M, _FAR_M)
    k = u.slots["k", None]
    p[k] = np.maximum(p[k], _SOFT * np.median(p[k]))
    return point(h, signals, p, late)


def _all_beside(turn: Turn, whiten: Whitener) -> Comparison:
    """Every cause that is not named yet, in each of its shapes. What only doubts the clock is no cause once one is named."""
    taken = {cause.effect.name for cause in turn.causes}
    left = [e for e in EFFECTS.values() if e.name not in taken and not (taken and e.of_clock)]
    every = [(e, shape) for e in left for shape in e.shapes]
    return compare(turn.end.point, turn.causes, every, turn.end.known, whiten, turn.floor)


def rank(now: Comparison) -> list[Candidate]:
    """Every effect in its best shape and place, the most telling first."""
    arm = now.point.hypothesis.arm
    base = now.crossed()
    best: dict[str, Candidate] = {}
    for group in now.groups:
        effect, options = group.effect, []
        for where in effect.wheres(arm):
            columns = group.columns[list(where.columns)]
            # the first cause that is not the clock itself puts a clock in doubt which rests on the base model's laws
            doubted = now.doubted or (not len(now.held) and not effect.of_clock)
            gains = base - now.crossed(columns, doubted)
            options.append(Candidate(effect, group.shape, where, columns, gains, len(columns) + doubted))
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


def entered(c: Candidate) -> Cause:
    """A candidate as a cause that does nothing yet."""
    return Cause(c.effect, c.where, np.zeros(len(c.where.columns)), dict(c.shape))


def refined(
    at: Point, h: Hypothesis, causes: tuple[Cause, ...], data: Sequence[DataSet], whiten: Whitener
) -> tuple[Comparison, tuple[Cause, ...]]:
    """The base model's numbers, the causes' and doubtful clocks fitted together from a point on, by Levenberg and Marquardt."""
    now = _seen_from(_at(at, believed(h, causes), data, at.p, at.late), causes, whiten)
    best, damping = (now, causes), 0.0
    for _ in range(_ROUNDS):
        if now.merit - now.fit().loss < _SETTLED * max(1.0, now.merit / now.rows):
            break
        fit = now.fit(damping=damping)
        step = np.append(fit.numbers[: now.base], fit.numbers[now.base + len(now.nuisances) :])
        p, changed = _stepped(now.point, causes, step)
        late = now.point.late + now.clock_moved(fit) if now.doubted else now.point.late
        there = _seen_from(_at(now.point, believed(h, changed), data, p, late), changed, whiten)
        # the base model's numbers are all but linear: they follow what the causes' are, in the next step
        gained = 1 - min(there.merit / now.merit, there.with_causes_as_they_are / now.with_causes_as_they_are)
        if gained > 0:
            now, causes = there, changed
            damping = damping / 10 if damping > _FIRST_DAMPING else 0.0
            if now.merit < best[0].merit:
                best = now, causes
            if gained < _GAINED:
                break
        else:
            damping = max(_FIRST_DAMPING, 10 * damping)
            if damping > _MOST_DAMPING:
                break
    return best


def _seen_from(at: Point, causes: tuple[Cause, ...], whiten: Whitener) -> Comparison:
    """A point with the causes in it, and what small errors would do there."""
    return compare(at, causes, (), errors(at), whiten)


def _at(near: Point, h: Hypothesis, data: Sequence[DataSet], p: Array, late: Array) -> Point:
    """A point; where only laws differ, the recordings read as they did."""
    was = near.hypothesis
    if h.neck != was.neck or h.late != was.late or np.any(h.misread != was.misread) or np.any(late != near.late):
        return point(h, read_all(h, data, late), p, late)
    return relaid(near, h, p)


def _stepped(at: Point, causes: tuple[Cause, ...], step: Array) -> tuple[Array, tuple[Cause, ...]]:
    """The base model's numbers and the causes a step further."""
    u, arm = at.unknowns, at.hypothesis.arm
    own, rest = np.split(step, [len(u.size)])
    p, moved = np.clip(at.p + u.size * own, u.low, u.high), []
    for cause in causes:
        part, rest = np.split(rest, [len(cause.sizes(arm))])
        moved.append(cause.stepped(part, arm))
    return p, tuple(moved)
