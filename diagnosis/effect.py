"""What may be wrong with a model: one cause, with numbers that are zero where it is absent.

Each effect says what its numbers do to the residuals, in columns, and how a hypothesis reads with them in it. Causes in the laws
(`OfLaw`), in the description of the arm (`OfArm`) and in what was read stand on an equal footing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from diagnosis.hypothesis import Hypothesis, at_rest
from diagnosis.linearisation import RecordingLinearisation
from identification.residuals import forces, on_channels
from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from mechanism.laws import LAWS, Term

Array = NDArray[np.float64]
Shape = Mapping[str, float]
"""numbers that say how an effect acts, not how much: by term"""
_SLIGHTLY = 0.05
"""of a form's size, for its columns"""


@dataclass(frozen=True)
class Where:
    """One place of an effect, or all: the columns it takes."""

    label: str
    columns: tuple[int, ...]


class Effect:
    """A cause. Columns stand in the order of `terms`, each over its places."""

    name: ClassVar[str]
    words: ClassVar[str]
    """what a person reads"""
    place: ClassVar[str]
    """what its numbers belong to: cable, motor, joint, mechanism, bar; or all"""
    terms: ClassVar[tuple[Term, ...]]
    """amounts, with units and ranges"""
    shapes: ClassVar[tuple[Shape, ...]] = ({},)
    """what is tried of its form while causes are compared"""
    forms: ClassVar[tuple[Term, ...]] = ()
    """terms of these shapes, fitted once the cause is named"""
    first: ClassVar[int] = 1
    """index of the first place"""
    of_clock: ClassVar[bool] = False
    """whether it is the clock itself: where it is not, a clock that rests on the base model's laws is in doubt"""
    single: ClassVar[bool] = True
    """whether it may sit in one place alone"""

    def count(self, arm: Arm) -> int:
        """Places."""
        return self.terms[0].count(arm)

    def labels(self, arm: Arm) -> tuple[str, ...]:
        """Of its places, in the order of each term's columns."""
        if self.count(arm) == 1:
            return (self.place,)
        return tuple(f"{self.place} {i + 1}" for i in range(self.count(arm)))

    def wheres(self, arm: Arm) -> tuple[Where, ...]:
        """Everywhere first, then the places where it may be alone."""
        count = self.count(arm)
        every = Where("all", tuple(range(len(self.terms) * count)))
        if count == 1 or not self.single:
            return (every,)
        own = tuple(
            Where(label, tuple(k * count + i for k in range(len(self.terms))))
            for i, label in enumerate(self.labels(arm))
        )
        return (every, *own)

    def sizes(self, arm: Arm) -> Array:
        """What a person would call a change of each number, (Q,)."""
        return np.repeat([term.size for term in self.terms], len(self.labels(arm)))

    def least(self, arm: Arm) -> Array:
        """What each number may be at least, but for chance, (Q,)."""
        return np.repeat([term.low for term in self.terms], len(self.labels(arm)))

    def columns(self, at: RecordingLinearisation, shape: Shape) -> Array:
        """What a unit of each number does to the residuals of a recording, (C, S, Q)."""
        raise NotImplementedError

    def form_columns(self, at: RecordingLinearisation) -> Array:
        """What a unit of each form does where the hypothesis holds the cause, (C, S, forms)."""
        return np.zeros((*at.rows.residual.shape, 0))

    def added(self, h: Hypothesis, numbers: Array, shape: Shape) -> Hypothesis:
        """The hypothesis with these numbers (Q,) more."""
        raise NotImplementedError


class OfLaw(Effect):
    """A law of motors, cables or joints that the base model lacks."""

    law: ClassVar[str]
    by_vision: ClassVar[bool] = False
    """whether only vision shows it: elongations that the motors tell are never negative"""

    def columns(self, at: RecordingLinearisation, shape: Shape) -> Array:
        """By differences as large as what a person would call a change; shapes that the hypothesis holds stay."""
        now = self._values(at.hypothesis, shape)
        return np.concatenate([self._moved(at, now, term) for term in self.terms], axis=2)

    def form_columns(self, at: RecordingLinearisation) -> Array:
        if not self.forms:
            return super().form_columns(at)
        now = self._values(at.hypothesis, {})
        return np.concatenate([self._moved(at, now, term, _SLIGHTLY) for term in self.forms], axis=2)

    def _moved(self, at: RecordingLinearisation, now: Mapping[str, Array], term: Term, part: float = 1.0) -> Array:
        s, base, tension = at.told, at.told_forces, None
        if self.by_vision:
            s, base, tension = at.signals, at.forces, at.tension
        # a law does nothing where its amounts are zero, whatever its shape
        names = at.laws if self.law in at.laws else (*at.laws, self.law)
        h = part * term.size
        moved = {**at.values, **now, term.name: now[term.name] + h}
        other = forces(s, names, moved, at.x0, at.delay, tension=tension)
        return on_channels(s, base, other, term) / h

    def _values(self, h: Hypothesis, shape: Shape) -> dict[str, Array]:
        now = {**at_rest(h.arm, self.law), **{k: np.full(1, v) for k, v in shape.items()}}
        return now | {name: h.values[name] for name in now if name in h.values}

    def added(self, h: Hypothesis, numbers: Array, shape: Shape) -> Hypothesis:
        now = self._values(h, shape)
        for term, more in zip(self.terms, np.split(numbers, len(self.terms)), strict=True):
            now[term.name] = within(term, now[term.name] + more)
        return h.with_law(self.law, now)


def within(term: Term, value: Array) -> Array:
    """A term's value in its range; what is in proportion may come out below nothing by chance."""
    return np.clip(value, -term.high if term.linear and term.low == 0 else term.low, term.high)


class OfArm(Effect):
    """A number of neck.yaml that is not what the arm has."""

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        """neck.yaml with that much more at a place, counted from 0."""
        raise NotImplementedError

    def columns(self, at: RecordingLinearisation, shape: Shape) -> Array:
        h, size = at.hypothesis, self.terms[0].size
        arms = [arm_of(self.rewritten(h.neck, i, size)) for i in range(self.count(h.arm))]
        return np.stack([at.slow.change(arm=arm) for arm in arms], axis=-1) / size

    def added(self, h: Hypothesis, numbers: Array, shape: Shape) -> Hypothesis:
        neck = h.neck
        for i, amount in enumerate(numbers):
            if amount:
                neck = self.rewritten(neck, i, float(amount))
        return replace(h, neck=neck)


def of_law(law: str, *names: str) -> tuple[Term, ...]:
    """Terms of a law, by name."""
    own = {term.name: term for term in LAWS[law].terms}
    return tuple(own[name] for name in names)
