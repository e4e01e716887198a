"""What is wrong with a simulation, described: in which equation, under which conditions, going round with what, and when.

A pattern counts where it takes more of a residual than chance, beyond what the base model's own numbers and a drawing's per cents
could have made of it: an error in one equation drives these, and they leave their own smooth traces in the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_fit import FitStage
from diagnosis.conditions import Condition, conditions
from diagnosis.drum_periodogram import Periodic, periodic
from diagnosis.episodes import Course, Episode, brief, course, episodes
from diagnosis.excess import PLAIN, Excess
from diagnosis.explained_energy import Energy, autocovariance, energy, orthonormal
from diagnosis.linearisation import RecordingLinearisation

Array = NDArray[np.float64]

FALSE_ALARM = 0.01
"""of a whole diagnosis: each of its patterns has its part"""
CONSTANT = "always"
_SIMPLER = 0.95
"""of what the best pattern explains: a constant that explains as much stands for it"""
_WORTH = 0.05
"""of what stands above noise: what a pattern explains at least to be spoken of"""
_MATTERS = 0.25
"""of the same: what a pattern explains at least where all the rest comes in short episodes. It is 0.44 and more where it was
hidden, 0.15 where a cable was slack at times"""


@dataclass(frozen=True)
class Pattern:
    """A channel's residual against a condition, by bins: means and RMS before and after, and noise alone."""

    channel: int
    """counted from 0, the motors' before the joints'"""
    against: str
    unit: str
    at: Array
    """(K,) middles of bins, then what is in them"""
    before: Array
    after: Array
    before_rms: Array
    after_rms: Array
    noise: Array
    explains: float
    """share of what the channel has above noise, by the bins' means, less what chance would explain; 0 where all is noise"""
    own: float
    """the same of what the base model's numbers could not have made"""
    log_p: float
    """of chance to take as much of that"""
    periodic: Periodic | None = None


@dataclass(frozen=True)
class Signature:
    """The pattern of a kind that the channels above noise have in common, all patterns, and the course in time."""

    kind: str
    """periodic, drift, episodes, constant, or a condition's name; nothing where all is noise, unclear where nothing stands out"""
    shown: tuple[Pattern, ...]
    """those that show it, the clearest first"""
    episodes: tuple[Episode, ...]
    patterns: tuple[Pattern, ...]
    courses: tuple[Course, ...]
    channels: tuple[int, ...]
    """where it shows"""
    best: Pattern
    """the one that proves most"""

    @property
    def clear(self) -> tuple[Pattern, ...]:
        """Patterns that chance does not make, in channels above noise."""
        return _clear(self.patterns)


def signature(first: FitStage, then: FitStage) -> Signature:
    """Of what the base model leaves; then: with the causes."""
    base, before = first.end, first.beyond
    left, last = base.left(first.fit), then.end.left(then.fit)
    places = base.point.places
    courses = tuple(
        course(place, was, now, drawn) for place, was, now, drawn in zip(places, left, last, first.floor, strict=True)
    )
    at = [_grid(place.signals.low_pass.kept, place.signals.low_pass.factor) for place in places]
    own = base.base + len(base.nuisances)
    patterns: list[Pattern] = []
    for c in range(len(before.rms)):
        excess = float(before.rms[c] ** 2 - before.floor[c] ** 2) if before.ratio[c] > PLAIN else np.inf
        channel = _Channel(
            number=c,
            was=[r[c] for r in left],
            now=[r[c] for r in last],
            drawn=[[d[c] for d in draws] for draws in first.floor],
            beneath=_basis(np.concatenate([m[c, :, :own] for m in base.matrix])),
            at=at,
            excess=excess * sum(r.shape[1] for r in left),
        )
        patterns += [channel.pattern(condition) for condition in conditions(places, c)]
        patterns.append(channel.pattern(Condition(CONSTANT, "", tuple(np.zeros(r.shape[1]) for r in left), turns=True)))
        if c < places[0].signals.arm.M:
            turning = periodic(channel.rest, places, c, channel.beneath, channel.rest_known)
            patterns += [channel.wave(turning, places)] if turning is not None else []
    return _named(tuple(patterns), courses, before)


class _Channel:
    """Residuals of one channel: whole, and beyond what the base model's numbers could have made."""

    def __init__(
        self,
        number: int,
        was: Sequence[Array],
        now: Sequence[Array],
        drawn: Sequence[Sequence[Array]],
        beneath: Array,
        at: Sequence[NDArray[np.intp]],
        excess: float,
    ) -> None:
        self.number, self.was, self.now, self.drawn, self.beneath, self.excess = (
            number,
            was,
            now,
            drawn,
            beneath,
            excess,
        )
        flat = np.concatenate(was)
        self.rest = np.split(flat - beneath @ (beneath.T @ flat), np.cumsum([len(r) for r in was])[:-1])
        self.known, self.rest_known = autocovariance(was, at), autocovariance(self.rest, at)

    def pattern(self, c: Condition) -> Pattern:
        """Against a condition."""
        (before, before_rms), (after, after_rms) = c.means(self.was), c.means(self.now)
        noise = np.sqrt(np.mean([c.means(d)[1] ** 2 for d in zip(*self.drawn, strict=True)], axis=0))
        columns = c.columns()
        whole = energy(self.was, columns, np.zeros((len(self.beneath), 0)), self.known)
        beyond = energy(self.rest, columns, self.beneath, self.rest_known)
        explains = min(1.0, max(0.0, (whole.taken - whole.expected) / self.excess))
        at, _ = c.bins()
        return Pattern(
            self.number,
            c.name,
            c.unit,
            at,
            before,
            after,
            before_rms,
            after_rms,
            noise,
            explains,
            self._share(beyond),
            beyond.log_p,
        )

    def wave(self, turning: Periodic, places: Sequence[RecordingLinearisation]) -> Pattern:
        """Against the drum's angle, folded into one of so many waves a turn."""
        angles = [p.signals.theta[p.signals.low_pass.kept, self.number] / turning.gear for p in places]
        phase = tuple(turning.order * a / (2 * np.pi) % 1 for a in angles)
        folded = self.pattern(Condition("drum's wave", "wave", phase, turns=True))
        return replace(folded, periodic=turning, own=self._share(turning.energy), log_p=turning.log_p)

    def _share(self, of: Energy) -> float:
        return max(0.0, of.taken - of.expected) / sum(float(r @ r) for r in self.rest)


def _named(patterns: tuple[Pattern, ...], courses: tuple[Course, ...], before: Excess) -> Signature:
    plain = [k for k in range(len(before.rms)) if before.ratio[k] > PLAIN]
    clear = _clear(patterns)
    worst = int(np.argmax(before.ratio))
    best = max(clear or tuple(p for p in patterns if p.channel == worst), key=lambda p: (p.explains, -p.log_p))
    best = _simpler(best, clear)
    if not plain:
        return Signature("nothing", (), (), patterns, courses, (), best)
    short = {k: brief(courses, k) for k in plain}
    votes: dict[str, list[Pattern]] = {}
    for channel in plain:
        own = [p for p in clear if p.channel == channel]
        if own:
            most = _simpler(max(own, key=lambda p: p.own), own)
            votes.setdefault(kind_of(most), []).append(most)
    weight = {kind: sum(p.own for p in voted) for kind, voted in votes.items()}
    # what follows a condition may come and go with it; traces of what is brief may follow one a little
    if any(short.values()) and max((p.explains for p in clear), default=0.0) < _MATTERS:
        where = tuple(k for k in short if short[k])
        return Signature("episodes", (), episodes(courses, where), patterns, courses, where, best)
    if not weight:
        return Signature("unclear", (), (), patterns, courses, tuple(plain), best)
    kind = max(weight, key=lambda k: weight[k])
    shown = tuple(sorted(votes[kind], key=lambda p: -p.own))
    return Signature(kind, shown, (), patterns, courses, tuple(sorted(p.channel for p in shown)), best)


def _clear(patterns: Sequence[Pattern]) -> tuple[Pattern, ...]:
    least = np.log(FALSE_ALARM / len(patterns))
    return tuple(p for p in patterns if p.log_p < least and p.explains > _WORTH)


def kind_of(p: Pattern) -> str:
    """What a pattern says."""
    if p.periodic is not None:
        return "periodic"
    if p.against.startswith("time"):
        return "drift"
    return "constant" if p.against == CONSTANT else p.against


def _simpler(best: Pattern, clear: Sequence[Pattern]) -> Pattern:
    """A constant in its place where that explains as much."""
    same = (p for p in clear if p.against == CONSTANT and p.channel == best.channel)
    return next((p for p in same if p.explains >= _SIMPLER * best.explains), best)


def _basis(columns: Array) -> Array:
    size = np.linalg.norm(columns, axis=0)
    return orthonormal(columns[:, size > 0] / size[size > 0])


def _grid(kept: NDArray[np.intp], factor: int) -> NDArray[np.intp]:
    return (kept - kept[0]) // factor
