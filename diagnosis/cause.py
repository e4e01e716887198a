"""An effect that is taken for a cause: where it sits, and its numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.effect import Effect, Where, within
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import RecordingLinearisation
from mechanism.arm import Arm

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cause:
    """An effect with numbers for the columns of its place, then its forms."""

    effect: Effect
    where: Where
    amounts: Array
    """(len(where.columns),)"""
    forms: Mapping[str, float]

    def columns(self, at: RecordingLinearisation) -> Array:
        """What a person's change of each amount and form does to the residuals, (C, S, Q)."""
        amounts = self.effect.columns(at, self.forms)[..., list(self.where.columns)]
        return np.concatenate([amounts, self.effect.form_columns(at)], axis=2) * self.sizes(at.signals.arm)

    def sizes(self, arm: Arm) -> Array:
        """What a person would call a change of each number."""
        return np.append(self.effect.sizes(arm)[list(self.where.columns)], [term.size for term in self.effect.forms])

    def stepped(self, numbers: Array, arm: Arm) -> "Cause":
        """With these numbers, in sizes, more."""
        more = numbers * self.sizes(arm)
        count = len(self.amounts)
        of = [self.effect.terms[c // len(self.effect.labels(arm))] for c in self.where.columns]
        amounts = [float(within(t, a + m)) for t, a, m in zip(of, self.amounts, more[:count], strict=True)]
        forms = dict(self.forms)
        for term, change in zip(self.effect.forms, more[count:], strict=True):
            # a form is a scale: one step at most halves or doubles it
            old = forms[term.name]
            forms[term.name] = float(within(term, np.clip(old + change, old / 2, 2 * old)))
        return replace(self, amounts=np.array(amounts), forms=forms)


def believed(h: Hypothesis, causes: Sequence[Cause]) -> Hypothesis:
    """A hypothesis with causes in it."""
    for cause in causes:
        numbers = np.zeros(len(cause.effect.sizes(h.arm)))
        numbers[list(cause.where.columns)] = cause.amounts
        h = cause.effect.added(h, numbers, cause.forms)
    return h
