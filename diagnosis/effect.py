"""What may be wrong with a model: one cause, with amounts that are zero where it is absent.

Each effect says what its amounts do to the residuals, in columns, and how a hypothesis reads with them in it. Causes in the laws
(`LawEffect`), in the description of the arm (`DescriptionEffect`) and in how a recording was read stand on an equal footing.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from diagnosis.check_fault import CheckFault
from diagnosis.hypothesis import Hypothesis, inactive_values
from diagnosis.linearisation import RecordingLinearisation
from diagnosis.shown_by import ShownBy
from identification.residuals import forces_of_moved_law, law_forces, memory_of_moved_law, residual_change
from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from mechanism.laws import Term, law_named
from mechanism.machine import Machine

Array = NDArray[np.float64]
Shape = Mapping[str, float | tuple[float, ...]]
"""numbers that say how an effect acts, not how much: by term, one for all places, or one for each of them"""
Numbers = dict[tuple[str, int | None], float]
"""by name and index, as in a record's parameters"""
_SHAPE_STEP = 0.05
"""step of the differences that give columns of shape terms, in sizes of the term"""


@dataclass(frozen=True)
class Placement:
    """Where an effect sits, at one place or at all, and which of its columns that takes."""

    label: str
    columns: tuple[int, ...]


class Effect:
    """A cause. Its Q columns stand in the order of `terms`, each over its places."""

    name: ClassVar[str]
    words: ClassVar[str]
    """what a person reads"""
    place: ClassVar[str]
    """what its amounts belong to: cable, motor, joint, mechanism, bar; or the one place that there is of it"""
    part: ClassVar[str] = ""
    """what of that a drawing of the arm marks, where that is not the place itself: pulleys, springs"""
    shown_by: ClassVar[ShownBy]
    """against which variable, and in which equation, a picture shows it"""
    terms: ClassVar[tuple[Term, ...]]
    """amounts, with units and ranges; the first one says what would tell the effect"""
    shape_terms: ClassVar[tuple[Term, ...]] = ()
    """numbers that say how it acts and not how much, fitted once the cause is named"""
    start_shapes: ClassVar[tuple[Shape, ...]] = ({},)
    """values of the shape terms that are tried while causes are compared"""
    first_index: ClassVar[int] = 1
    """index of the first place"""
    is_clock: ClassVar[bool] = False
    """whether it is the clock itself: where another effect is the cause, a clock that rests on the base model's laws is in doubt"""
    has_tolerance: ClassVar[bool] = False
    """whether it is a number that neck.yaml gives a tolerance, or adds to one: within that it is no cause, beyond it is one"""
    may_sit_alone: ClassVar[bool] = True
    """whether it is looked for in one place only; where it is not, a fit of all places may still tell that it is in one"""
    may_sit_everywhere: ClassVar[bool] = True
    """whether it may sit in all places at once, where that is not the scale of all forces or lengths, which nothing tells"""
    in_full: ClassVar[bool] = False
    """whether it is there in full or not at all: a fit has its amounts at one, and numbers of its shape alone"""
    check_fault: ClassVar[CheckFault | None] = None
    """how `xneck check` speaks of it, where it is one of its faults"""
    truth_names: ClassVar[tuple[tuple[str, str], ...]] = ()
    """terms, and what a study's truth calls them, where that is not the term's name"""
    order: ClassVar[int] = 1000
    """its place in tables and lists; effects with the same number stand by name"""

    @property
    def would_tell(self) -> str:
        """What to record or to measure to tell it."""
        return self.terms[0].would_tell

    def place_count(self, arm: Arm) -> int:
        """Number of places where it may sit."""
        return self.terms[0].count(arm)

    def shape_count(self, places: int) -> int:
        """How many numbers of which nothing is known say how it acts where it sits in so many places."""
        return sum(1 if term.of == "arm" else places for term in self.shape_terms if np.isinf(term.sigma))

    def place_labels(self, arm: Arm) -> tuple[str, ...]:
        """Names of its places, in the order of each term's columns."""
        if self.place_count(arm) == 1:
            return (self.place,)
        return tuple(f"{self.place} {i + 1}" for i in range(self.place_count(arm)))

    def placements(self, arm: Arm) -> tuple[Placement, ...]:
        """Everywhere first, if it may, then the places where it may sit alone."""
        count = self.place_count(arm)
        everywhere = Placement("all", tuple(range(len(self.terms) * count)))
        if count == 1 or not self.may_sit_alone:
            return (everywhere,)
        single = tuple(self.alone_at(place, arm) for place in range(count))
        return (everywhere, *single) if self.may_sit_everywhere else single

    def alone_at(self, place: int, arm: Arm) -> Placement:
        """At one of its places, counted from 0."""
        labels = self.place_labels(arm)
        return Placement(labels[place], tuple(k * len(labels) + place for k in range(len(self.terms))))

    def sizes(self, arm: Arm) -> Array:
        """What a person would call a change of each amount, (Q,)."""
        return np.repeat([term.size for term in self.terms], len(self.place_labels(arm)))

    def tolerances(self, neck: Neck) -> Array:
        """To what each amount is known beforehand, (Q,): zero of what is no number of neck.yaml, or adds to several."""
        return np.zeros(len(self.sizes(arm_of(neck))))

    def lower_bounds(self, arm: Arm) -> Array:
        """What each amount may be at least, but for chance, (Q,)."""
        return np.repeat([term.low for term in self.terms], len(self.place_labels(arm)))

    def least_numbers(self, arm: Arm) -> Array:
        """The same in sizes, (Q,): chance, and a law of another form, may take what is nothing a little below."""
        return self.lower_bounds(arm) / self.sizes(arm) - 1.0

    def least_reached(self, arm: Arm) -> Array:
        """The least that a step can take, in sizes, (Q,): of a lag or a play there is none below nothing, so none is promised."""
        linear = np.repeat([term.linear for term in self.terms], len(self.place_labels(arm)))
        return np.where(linear, self.least_numbers(arm), self.lower_bounds(arm) / self.sizes(arm))

    def upper_bounds(self, arm: Arm) -> Array:
        """What no amount reaches, (Q,)."""
        return np.repeat([term.high for term in self.terms], len(self.place_labels(arm)))

    def columns(self, recording: RecordingLinearisation, shape: Shape) -> Array:
        """What a unit of each amount does to the residuals of a recording, (C, S, Q)."""
        raise NotImplementedError

    def shape_columns(self, recording: RecordingLinearisation, amounts: Array, shape: Shape) -> Array:
        """What a unit of each shape term does where the hypothesis holds the cause, each over its places, (C, S, columns)."""
        return np.zeros((*recording.rows.residual.shape, 0))

    def added_to(self, h: Hypothesis, amounts: Array, shape: Shape) -> Hypothesis:
        """The hypothesis with these amounts (Q,) on top of what it holds."""
        raise NotImplementedError

    def is_reached(self, recording: RecordingLinearisation, where: Placement) -> bool:
        """Whether a recording whose hypothesis holds it comes to where it acts: elsewhere it only bends another law."""
        return True

    def true_numbers(self, parameters: Mapping[str, float], truth: Mapping[str, Any], place: int | None) -> Numbers:
        """The truth of a study in this effect's own numbers; none where the hidden law has another form.

        parameters: those of the hidden effect. One that bears a term's name, or `truth_names`' for it, is that term's number:
        followed by an index of that place, else of `place`, and of all places where it was hidden everywhere (place None).
        """
        names = dict(self.truth_names)
        return {
            (term.name, index): value
            for term in (*self.terms, *self.shape_terms)
            for index, value in _indexed(parameters, names.get(term.name, term.name), term, truth, place)
        }


def _indexed(
    parameters: Mapping[str, float], name: str, term: Term, truth: Mapping[str, Any], place: int | None
) -> Iterator[tuple[int | None, float]]:
    """Indices and values of the parameters that are called `name`, with or without a number behind it."""
    for key, value in parameters.items():
        match = re.fullmatch(rf"{name}(\d*)", key)
        if match is None:
            continue
        if match[1]:
            yield int(match[1]), value
        elif term.of == "arm":
            yield None, value
        elif place is not None:
            yield place, value
        else:
            count = len(truth["k"]) if term.of == "cable" else len(truth["neck"]["mechanisms"])
            yield from ((i + 1, value) for i in range(count))


class LawEffect(Effect):
    """A law of motors, cables or joints that the base model lacks."""

    law: ClassVar[str]
    from_vision: ClassVar[bool] = False
    """whether only elongations that vision measures show it: those that follow from the motors are never negative"""

    def columns(self, recording: RecordingLinearisation, shape: Shape) -> Array:
        """By differences as large as what a person would call a change; in a shape that is not held, from nothing on."""
        held = recording.hypothesis.values
        elsewhere = self.law in recording.laws and any(np.any(held[k] != np.asarray(v)) for k, v in shape.items())
        values = self._inactive(recording.hypothesis, shape) if elsewhere else self._values(recording.hypothesis, shape)
        return np.concatenate(
            [self._difference_quotient(recording, values, term, 1.0, elsewhere) for term in self.terms], axis=2
        )

    def shape_columns(self, recording: RecordingLinearisation, amounts: Array, shape: Shape) -> Array:
        if not self.shape_terms:
            return super().shape_columns(recording, amounts, shape)
        values = self._values(recording.hypothesis, {})
        return np.concatenate(
            [self._difference_quotient(recording, values, term, _SHAPE_STEP) for term in self.shape_terms], axis=2
        )

    def _difference_quotient(
        self,
        recording: RecordingLinearisation,
        values: Mapping[str, Array],
        term: Term,
        step: float,
        elsewhere: bool = False,
    ) -> Array:
        """Of the residuals by one term, whose step is in its sizes, (C, S, places); elsewhere: not where the hypothesis is."""
        signals, base, tension = recording.motor_signals, recording.motor_forces, recording.tension
        if self.from_vision:
            signals, base = recording.signals, recording.forces
        # a law does nothing where its amounts are zero, whatever its shape
        laws = recording.laws if self.law in recording.laws else (*recording.laws, self.law)
        h = step * term.size
        values = {**recording.values, **values}
        moved = {term.name: values[term.name] + h}
        x0, delay, memory = recording.x0, recording.delay, recording.memory
        if elsewhere:
            memory = memory_of_moved_law(signals, Machine(signals.arm, laws, values), x0, self.law, memory)
            base = law_forces(signals, laws, values, x0, delay, memory, tension)
        other = forces_of_moved_law(signals, base, laws, values, self.law, moved, x0, delay, memory, tension)
        return residual_change(signals, base, other, term) / h

    def _values(self, h: Hypothesis, shape: Shape) -> dict[str, Array]:
        """Values of the law's terms: the hypothesis's, else those of the shape, else those at which the law does nothing."""
        values = self._inactive(h, shape)
        return values | {name: h.values[name] for name in values if name in h.values}

    def _inactive(self, h: Hypothesis, shape: Shape) -> dict[str, Array]:
        """The same as if the hypothesis did not hold the law."""
        return {**inactive_values(h.arm, self.law), **{k: np.atleast_1d(v) for k, v in shape.items()}}

    def added_to(self, h: Hypothesis, amounts: Array, shape: Shape) -> Hypothesis:
        values = self._values(h, shape)
        for term, amount in zip(self.terms, np.split(amounts, len(self.terms)), strict=True):
            values[term.name] = clip_to_range(term, values[term.name] + amount)
        return h.with_law(self.law, values)


def clip_to_range(term: Term, value: Array) -> Array:
    """A term's value in its range; what is in proportion may come out below nothing by chance."""
    return np.clip(value, -term.high if term.linear and term.low == 0 else term.low, term.high)


class DescriptionEffect(Effect):
    """A number of neck.yaml that is not what the arm has."""

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        """neck.yaml with that much more at a place, counted from 0; the places of a second term follow those of the first."""
        raise NotImplementedError

    def columns(self, recording: RecordingLinearisation, shape: Shape) -> Array:
        h = recording.hypothesis
        changes = [
            recording.sensitivity.residual_change(arm=arm_of(self.rewritten(h.neck, i, size))) / size
            for i, size in enumerate(self.sizes(h.arm))
        ]
        return np.stack(changes, axis=-1)

    def added_to(self, h: Hypothesis, amounts: Array, shape: Shape) -> Hypothesis:
        neck = h.neck
        for i, amount in enumerate(amounts):
            if amount:
                neck = self.rewritten(neck, i, float(amount))
        return replace(h, neck=neck)


def law_terms(law: str, *names: str) -> tuple[Term, ...]:
    """Terms of a law, by name."""
    by_name = {term.name: term for term in law_named(law).terms}
    return tuple(by_name[name] for name in names)
