"""An effect that is taken for a cause: where it sits, and its numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.effect import Effect, Placement, clip_to_range
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import RecordingLinearisation
from mechanism.arm import Arm

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cause:
    """An effect at its place, with numbers."""

    effect: Effect
    where: Placement
    amounts: Array
    """(len(where.columns),)"""
    shape: Mapping[str, float]

    def columns(self, recording: RecordingLinearisation) -> Array:
        """What a person's change of each amount, then of each shape term, does to the residuals, (C, S, Q)."""
        amounts = self.effect.columns(recording, self.shape)[..., list(self.where.columns)]
        columns = np.concatenate([amounts, self.effect.shape_columns(recording)], axis=2)
        return columns * self.sizes(recording.signals.arm)

    def sizes(self, arm: Arm) -> Array:
        """What a person would call a change of each amount, then of each shape term, (Q,)."""
        amounts = self.effect.sizes(arm)[list(self.where.columns)]
        return np.append(amounts, [term.size for term in self.effect.shape_terms])

    def at_limit(self) -> NDArray[np.bool_]:
        """Which shape terms are at the end of their range, from where no straight step leads on."""
        ends = ((term.low, term.high) for term in self.effect.shape_terms)
        values = (self.shape[term.name] for term in self.effect.shape_terms)
        return np.array([value in (low, high) for value, (low, high) in zip(values, ends, strict=True)], dtype=bool)

    def stepped(self, step: Array, arm: Arm) -> "Cause":
        """With amounts and shape terms moved by a step (Q,), in their sizes."""
        change = step * self.sizes(arm)
        count = len(self.amounts)
        terms = [self.effect.terms[c // len(self.effect.place_labels(arm))] for c in self.where.columns]
        amounts = [
            float(clip_to_range(term, amount + by))
            for term, amount, by in zip(terms, self.amounts, change[:count], strict=True)
        ]
        shape = dict(self.shape)
        for term, by in zip(self.effect.shape_terms, change[count:], strict=True):
            old, new = shape[term.name], shape[term.name] + by
            if term.low > 0:  # of a scale one step at most halves or doubles it
                new = np.clip(new, old / 2, 2 * old)
            shape[term.name] = float(clip_to_range(term, new))
        return replace(self, amounts=np.array(amounts), shape=shape)


def with_causes(h: Hypothesis, causes: Sequence[Cause]) -> Hypothesis:
    """A hypothesis with causes in it."""
    for cause in causes:
        amounts = np.zeros(len(cause.effect.sizes(h.arm)))
        amounts[list(cause.where.columns)] = cause.amounts
        h = cause.effect.added_to(h, amounts, cause.shape)
    return h
