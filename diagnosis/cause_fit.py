"""Causes fitted together with the base model's numbers and doubtful clocks, and what they leave."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause, believed
from diagnosis.comparison import DELAY_SIGMA, Comparison, Fitted, compare
from diagnosis.excess import Excess, excess
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import Linearisation, point, read_all, relaid, sought
from diagnosis.noise_ensemble import NoiseEnsemble, noise, quiet, seen_noise, whitener
from diagnosis.nuisances import WALL, errors
from identification.dataset.dataset import DataSet
from identification.estimates import check_motion
from identification.fitting import solve, stretch_starts
from identification.whitening import Whitener

Array = NDArray[np.float64]

_ROUNDS = 24
_FAR_M, _SOFT = 5e-3, 0.3
_LATE_S = WALL * DELAY_SIGMA
"""x0 beyond the description's, stiffness over the middle one, and the delay: a fit begins within"""
_SETTLED, _GAINED = 0.3, 1e-3
"""where a step would take less away, in units of a row's loss, it is not taken; where it took less of the loss it was the last"""
_SURELY = 3.0
"""standard deviations"""
_FIRST_DAMPING, _MOST_DAMPING = 1e-3, 10.0
_EASED, _TIGHTENED = 3.0, 8.0


@dataclass(frozen=True)
class FitStage:
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
        """Of all numbers of the fit, in their sizes, (K,); infinite where nothing tells them."""
        variance = np.diag(self.end.covariance(self.fit))
        return np.sqrt(np.where(variance > 0, variance, np.inf))

    @cached_property
    def sigma_of_causes(self) -> tuple[Array, ...]:
        """Of each cause's amounts, then its forms, in their units."""
        arm, sigma = self.end.point.hypothesis.arm, self.sigma[self.end.base + len(self.end.nuisances) :]
        sizes = [cause.sizes(arm) for cause in self.causes]
        parts = np.split(sigma, np.cumsum([len(size) for size in sizes]))
        return tuple(size * part for size, part in zip(sizes, parts[:-1], strict=True))

    @cached_property
    def possible(self) -> bool:
        """Whether no cause does surely less than nothing: friction that drives, a mass that lifts."""
        arm = self.end.point.hypothesis.arm
        for cause, sigma in zip(self.causes, self.sigma_of_causes, strict=True):
            least = cause.effect.least(arm)[list(cause.where.columns)]
            if np.any(cause.amounts < least - _SURELY * sigma[: len(cause.amounts)]):
                return False
        return True

    @cached_property
    def loss(self) -> float:
        """Of blocks where all but their fold were fitted, and what a last straight step promises but was not taken."""
        return float(self.end.crossed().sum()) + max(0.0, self.end.merit - self.fit.loss)

    @cached_property
    def beyond(self) -> Excess:
        """What stands above noise."""
        return excess(self.end.left(self.fit), self.floor, [place.unsure for place in self.end.point.places])


class Trial:
    """Recordings of one arm, on which causes are tried. Raises Refused where a motor stands still."""

    def __init__(self, h: Hypothesis, read: Sequence[NoiseEnsemble]) -> None:
        self._h, self._read, self._data = h, read, [one.data for one in read]
        self._at = _begun(h, self._data)
        starts = [stretch_starts(place.signals) for place in self._at.places]
        self.whiten = whitener(seen_noise(self._at, read), starts, h.arm.M)
        self._known: dict[tuple[object, ...], FitStage] = {}

    def begin(self) -> FitStage:
        """Without a cause."""
        return self.settled(self._at, ())

    def settled(self, at: Linearisation, causes: tuple[Cause, ...]) -> FitStage:
        """Fitted with these causes, from a point on where they were not fitted before, and what stands above noise there."""
        which = tuple((c.effect.name, c.where.label, *sorted(c.forms.items())) for c in causes)
        if which not in self._known:
            self._known[which] = self._fitted(at, causes, self.whiten)
        return self._known[which]

    def weighed(self, turn: FitStage) -> tuple[FitStage, Whitener]:
        """The same causes fitted anew where a law's form leaves more than noise, and the whitener of that fit.

        A channel counts by what it leaves: else clocks and friction would give way to what no number mends."""
        left = zip(turn.end.point.places, turn.end.left(turn.fit), strict=True)
        white = [self.whiten(r, stretch_starts(place.signals), place.unsure) for place, r in left]
        loud = np.sqrt(np.mean(np.concatenate(white, axis=1) ** 2, axis=1))
        whiten = self.whiten.quieter(np.maximum(loud, 1.0))
        return self._fitted(turn.end.point, turn.causes, whiten), whiten

    def _fitted(self, at: Linearisation, causes: tuple[Cause, ...], whiten: Whitener) -> FitStage:
        end, causes = _refined(at, self._h, causes, self._data, whiten)
        floor = noise(end.point, self._read)
        return FitStage(end, causes, tuple(floor), quiet(floor, end.point, whiten), end.fit())


def _begun(h: Hypothesis, data: Sequence[DataSet]) -> Linearisation:
    """The base model's numbers by least squares, kept from where a cause that is not in it may have driven them."""
    late = np.zeros(len(data))
    signals = read_all(h, data, late)
    check_motion(signals)
    u = sought(h, len(data))
    p = solve(signals, u).least_squares.copy()
    for recording in range(len(data)):
        slot = u.slots["x0", recording]
        p[slot] = np.clip(p[slot], -_FAR_M, _FAR_M)
        slot = u.slots["delay", recording]
        p[slot] = np.clip(p[slot], -_LATE_S, _LATE_S)
    k = u.slots["k", None]
    p[k] = np.maximum(p[k], _SOFT * np.median(p[k]))
    return point(h, signals, p, late)


def _refined(
    at: Linearisation, h: Hypothesis, causes: tuple[Cause, ...], data: Sequence[DataSet], whiten: Whitener
) -> tuple[Comparison, tuple[Cause, ...]]:
    """The base model's numbers, the causes' and doubtful clocks fitted together from a point on, by Levenberg and Marquardt."""
    now = _seen_from(_at(at, believed(h, causes), data, at.p, at.late), causes, whiten)
    best, damping, little = (now, causes), 0.0, False
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
            damping = damping / _EASED if damping > _FIRST_DAMPING else 0.0
            if now.merit < best[0].merit:
                best = now, causes
            if gained < _GAINED and (damping == 0 or little):
                break
            little = gained < _GAINED
        else:
            damping = max(_FIRST_DAMPING, _TIGHTENED * damping)
            if damping > _MOST_DAMPING:
                break
    return best


def _seen_from(at: Linearisation, causes: tuple[Cause, ...], whiten: Whitener) -> Comparison:
    """A point with the causes in it, and what small errors would do there."""
    return compare(at, causes, (), errors(at), whiten)


def _at(near: Linearisation, h: Hypothesis, data: Sequence[DataSet], p: Array, late: Array) -> Linearisation:
    """A point; where only laws differ, the recordings read as they did."""
    was = near.hypothesis
    read = (h.neck, h.late, h.stale, *h.misread, *late)
    if read != (was.neck, was.late, was.stale, *was.misread, *near.late):
        return point(h, read_all(h, data, late), p, late)
    return relaid(near, h, p)


def _stepped(at: Linearisation, causes: tuple[Cause, ...], step: Array) -> tuple[Array, tuple[Cause, ...]]:
    """The base model's numbers and the causes a step further."""
    u, arm = at.unknowns, at.hypothesis.arm
    own, rest = np.split(step, [len(u.size)])
    p, moved = np.clip(at.p + u.size * own, u.low, u.high), []
    for cause in causes:
        part, rest = np.split(rest, [len(cause.sizes(arm))])
        moved.append(cause.stepped(part, arm))
    return p, tuple(moved)
