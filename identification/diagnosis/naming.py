"""Which causes explain what the base model does not: the best one first, as long as one explains a part worth naming.

A cause is named where it takes MATERIAL of the loss away. With it go all others that explain as much but for TIED of it: data
cannot tell these apart. Of two that explain as much the one with fewer numbers stands for both.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset import DataSet
from identification.diagnosis.cause import Cause, believed
from identification.diagnosis.comparison import Comparison, begins, compare
from identification.diagnosis.effect import Effect, Shape, Where
from identification.diagnosis.effects import EFFECTS
from identification.diagnosis.excess import excess
from identification.diagnosis.hypothesis import Hypothesis
from identification.diagnosis.noise import Read, noise, whitener
from identification.diagnosis.nuisances import Errors, errors
from identification.diagnosis.point import Point, point, relaid
from identification.fitting import solve
from identification.whitening import Whitener

Array = NDArray[np.float64]

MATERIAL = 0.08
"""of the loss: what a cause must take away at least"""
TIED = 0.05
"""of what the best cause explains: nearer than that to it a cause is not told from it; laws have forms that nobody knows better"""
ALONE = 0.95
"""of what an effect explains everywhere: a place that explains as much has it alone"""
EXPLAINED = 0.6
"""of what stands above noise, that all causes together take away at least: else none is named"""
MOSTLY = 0.5
"""of what still stands above noise: what a further cause takes away at least"""
MOST = 3
_BETTER = 0.01
"""of what the best explains: by how much more numbers must explain more"""
_ROUNDS = 16
_FAR_M, _SOFT = 5e-3, 0.3
"""x0 beyond the description's, and stiffness over the middle one: a fit begins within"""
_SETTLED = 5e-3
"""of the loss: where a step would take less away it is not taken"""
_FIRST_DAMPING, _MOST_DAMPING = 1e-5, 0.5


@dataclass(frozen=True)
class Candidate:
    """An effect in its best shape and place, and what it takes from the loss."""

    effect: Effect
    shape: Shape
    where: Where
    gain: float


@dataclass(frozen=True)
class Named:
    """A cause, those that explain as much, and the loss before it."""

    best: Candidate
    tied: tuple[Candidate, ...]
    loss_before: float


@dataclass(frozen=True)
class Search:
    """Where it began, and where it ended."""

    base: Comparison
    end: Comparison
    named: tuple[Named, ...]
    causes: tuple[Cause, ...]
    """of these, with numbers"""
    whiten: Whitener
    floor_before: tuple[list[Array], ...]
    """residuals of noise alone, by recording and draw, at the beginning"""
    floor: tuple[list[Array], ...]
    """and at the end"""
    rankings: tuple[tuple[Candidate, ...], ...]
    """of every turn, the best first"""


def search(h: Hypothesis, read: Sequence[Read]) -> Search:
    """Causes beyond a hypothesis in recordings of one arm."""
    data = [one.data for one in read]
    at = point(h, data)
    at = relaid(at, h, _start(at))
    drawn = noise(at, read)
    whiten = whitener(drawn, [begins(place) for place in at.places], at.places[0].signals.arm.M)
    known = errors(at)
    at, _ = refined(at, h, (), data, known, whiten)
    named: list[Named] = []
    causes: tuple[Cause, ...] = ()
    rankings = []
    first: Comparison | None = None
    floor_before = floor = noise(at, read)
    begin, known_before = at, known
    while len(named) < MOST:
        taken = {cause.effect.name for cause in causes}
        every = [(e, shape) for e in EFFECTS.values() if e.name not in taken for shape in e.shapes]
        now = compare(at, causes, every, known, whiten)
        first = first or now
        fit = now.fit()
        beyond = excess(now.left(fit), floor)
        ranked = rank(now, fit.loss)
        rankings.append(ranked)
        if ranked[0].gain < MATERIAL * fit.loss or (named and not beyond.plain):
            break
        near = tied(ranked)
        more = (*causes, entered(near[0]))
        there, more = refined(at, h, more, data, known, whiten)
        errors_there, floor_there = errors(there), noise(there, read)
        then = compare(there, more, (), errors_there, whiten)
        # what a named cause leaves, for its law has another form, others may explain in part; a second cause explains most of it
        if named and excess(then.left(then.fit()), floor_there).energy > (1 - MOSTLY) * beyond.energy:
            break
        named.append(Named(near[0], near, fit.loss))
        at, causes, known, floor = there, more, errors_there, floor_there
    end = compare(at, causes, (), known, whiten)
    if first and named:
        before, after = excess(first.left(first.fit()), floor_before), excess(end.left(end.fit()), floor)
        if after.plain and after.energy > (1 - EXPLAINED) * before.energy:
            end, named, causes, floor = compare(begin, (), (), known_before, whiten), [], (), floor_before
    return Search(first or end, end, tuple(named), causes, whiten, tuple(floor_before), tuple(floor), tuple(rankings))


def rank(now: Comparison, loss: float) -> tuple[Candidate, ...]:
    """Every effect in its best shape and place, the most telling first."""
    arm = now.point.places[0].signals.arm
    best: dict[str, Candidate] = {}
    for group in now.groups:
        name = group.effect.name
        options = [
            Candidate(group.effect, group.shape, where, loss - now.fit(now.columns(group, where.columns)).loss)
            for where in group.effect.wheres(arm)
        ]
        most = max(option.gain for option in options)
        found = min(
            (o for o in options if o.gain >= most - (1 - ALONE) * abs(most)),
            key=lambda o: (len(o.where.columns), -o.gain),
        )
        if name not in best or found.gain > best[name].gain:
            best[name] = found
    return tuple(sorted(best.values(), key=lambda c: -c.gain))


def tied(ranked: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Those that explain as much as the best but for TIED of it, the most telling first.

    One with more numbers than another stays only where it explains more by them."""
    most = ranked[0].gain
    kept: list[Candidate] = []
    for c in sorted((c for c in ranked if c.gain >= (1 - TIED) * most), key=lambda c: (len(c.where.columns), -c.gain)):
        simpler = [k.gain for k in kept if len(k.where.columns) < len(c.where.columns)]
        if not simpler or c.gain > max(simpler) + _BETTER * most:
            kept.append(c)
    return tuple(sorted(kept, key=lambda c: -c.gain))


def entered(c: Candidate) -> Cause:
    """A candidate as a cause that does nothing yet."""
    return Cause(c.effect, c.where, np.zeros(len(c.where.columns)), dict(c.shape))


def refined(
    at: Point, h: Hypothesis, causes: tuple[Cause, ...], data: Sequence[DataSet], known: Errors, whiten: Whitener
) -> tuple[Point, tuple[Cause, ...]]:
    """The base model's numbers and the causes' fitted together from a point on, by Levenberg and Marquardt."""
    at = _at(at, believed(h, causes), data, at.p)
    now = compare(at, causes, (), known, whiten)
    merit, damping = now.merit, 0.0
    gap = merit - now.fit().loss
    for _ in range(_ROUNDS):
        if gap < _SETTLED * merit:
            break
        fit = now.fit(damping=damping)
        step = np.append(fit.numbers[: now.base], fit.numbers[now.base + len(now.nuisances) :])
        p, changed = _stepped(at, causes, step)
        then = _at(at, believed(h, changed), data, p)
        there = compare(then, changed, (), known, whiten)
        # columns are told by the motors, so that the best numbers leave nothing along them, not the least of all
        left = there.merit - there.fit().loss
        if left < gap:
            at, now, causes, merit, gap = then, there, changed, there.merit, left
            damping = damping / 10 if damping > _FIRST_DAMPING else 0.0
        else:
            damping = max(_FIRST_DAMPING, 10 * damping)
            if damping > _MOST_DAMPING:
                break
    return at, causes


def _start(at: Point) -> Array:
    """Numbers of the base model by least squares, kept from where a cause that is not in it may have driven them."""
    u = at.unknowns
    p = solve([place.signals for place in at.places], u).least_squares.copy()
    for recording in range(len(at.places)):
        slot = u.slots["x0", recording]
        p[slot] = np.clip(p[slot], -_FAR_M, _FAR_M)
    k = u.slots["k", None]
    p[k] = np.maximum(p[k], _SOFT * np.median(p[k]))
    return p


def _at(near: Point, h: Hypothesis, data: Sequence[DataSet], p: Array) -> Point:
    """A point; where only laws differ, the recordings read as they did."""
    was = near.hypothesis
    if h.neck != was.neck or h.late != was.late or np.any(h.misread != was.misread):
        return point(h, data, p)
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
