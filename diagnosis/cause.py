"""An effect that is taken for a cause: where it sits, and its numbers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.effect import Effect, Placement, Shape, clip_to_range
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import RecordingLinearisation
from mechanism.arm import Arm
from mechanism.laws import Term

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cause:
    """An effect at its place, with numbers."""

    effect: Effect
    where: Placement
    amounts: Array
    """(len(where.columns),)"""
    shape: Shape

    @property
    def number_count(self) -> int:
        """Its amounts and the numbers of its shape."""
        return len(self.amounts) + self.effect.shape_count(len(self.where.columns) // len(self.effect.terms))

    def places(self, arm: Arm) -> list[int]:
        """Where it sits, counted from 0."""
        count = len(self.effect.place_labels(arm))
        return sorted({column % count for column in self.where.columns})

    def shape_numbers(self, arm: Arm) -> list[tuple[Term, int | None, float]]:
        """The numbers of its shape: term, place counted from 0, None of what is one for all, and value."""
        return [
            (term, place, float(values[place or 0]))
            for term in self.effect.shape_terms
            for values in [np.broadcast_to(self.shape[term.name], term.count(arm))]
            for place in ([None] if term.of == "arm" else self.places(arm))
        ]

    def columns(self, recording: RecordingLinearisation) -> Array:
        """What a person's change of each amount, then of each shape term, does to the residuals, (C, S, Q)."""
        amounts = self.effect.columns(recording, self.shape)[..., list(self.where.columns)]
        arm = recording.signals.arm
        every = [(term.name, i) for term in self.effect.shape_terms for i in range(term.count(arm))]
        own = [every.index((term.name, place or 0)) for term, place, _ in self.shape_numbers(arm)]
        shapes = self.effect.shape_columns(recording, self.amounts, self.shape)[..., own]
        return np.concatenate([amounts, shapes], axis=2) * self.sizes(arm)

    def sizes(self, arm: Arm) -> Array:
        """What a person would call a change of each amount, then of each number of the shape, (Q,)."""
        amounts = self.effect.sizes(arm)[list(self.where.columns)]
        return np.append(amounts, [term.size for term, *_ in self.shape_numbers(arm)])

    def at_limit(self, arm: Arm) -> NDArray[np.bool_]:
        """Which numbers of the shape are at the end of their range, from where no straight step leads on."""
        return np.array([value in (term.low, term.high) for term, _, value in self.shape_numbers(arm)], dtype=bool)

    def known_shape(self, arm: Arm) -> tuple[Array, Array]:
        """What is known of the numbers of its shape beforehand, from where they are: mean and sigma, in their sizes."""
        known = [(-value / term.size, term.sigma / term.size) for term, _, value in self.shape_numbers(arm)]
        mean, sigma = np.array(known).reshape(-1, 2).T
        return np.where(np.isfinite(sigma), mean, 0.0), sigma

    def least_steps(self, arm: Arm) -> Array:
        """How far down each amount may go from here, in its size, (len(amounts),)."""
        columns = list(self.where.columns)
        from_nothing = self.amounts / self.effect.sizes(arm)[columns]
        return np.minimum(self.effect.least_reached(arm)[columns] - from_nothing, 0.0)

    def begun(self) -> "Cause":
        """As a fit begins with it: in full where there is no less."""
        return replace(self, amounts=np.ones_like(self.amounts)) if self.effect.in_full else self

    def stepped(self, step: Array, arm: Arm) -> "Cause":
        """With amounts and the shape's numbers moved by a step (Q,), in their sizes."""
        change = step * self.sizes(arm)
        count = len(self.amounts)
        if self.effect.in_full:
            change[:count] = 0.0
        terms = [self.effect.terms[c // len(self.effect.place_labels(arm))] for c in self.where.columns]
        amounts = [
            float(clip_to_range(term, amount + by))
            for term, amount, by in zip(terms, self.amounts, change[:count], strict=True)
        ]
        shape = {t.name: np.broadcast_to(self.shape[t.name], t.count(arm)).copy() for t in self.effect.shape_terms}
        for (term, place, old), by in zip(self.shape_numbers(arm), change[count:], strict=True):
            new = old + by
            if term.low > 0:  # of a scale one step at most halves or doubles it
                new = np.clip(new, old / 2, 2 * old)
            shape[term.name][place or 0] = clip_to_range(term, new)
        values = {name: tuple(v.tolist()) if len(v) > 1 else float(v[0]) for name, v in shape.items()}
        return replace(self, amounts=np.array(amounts), shape={**self.shape, **values})


def with_causes(h: Hypothesis, causes: Sequence[Cause]) -> Hypothesis:
    """A hypothesis with causes in it."""
    for cause in causes:
        amounts = np.zeros(len(cause.effect.sizes(h.arm)))
        amounts[list(cause.where.columns)] = cause.amounts
        h = cause.effect.added_to(h, amounts, cause.shape)
    return h
