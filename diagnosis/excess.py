"""How far residuals stand above what noise alone leaves, channel by channel."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PLAIN = 1.25
"""times the floor: below, a channel is as good as noise. Forces are rounded, friction turns in its own way, a drawing's per cents
do not add up in a straight line: without any effect the worst channel of three arms came to 1.03, 1.07 and 1.12"""

_ROUNDS = 30
"""until noise is told to a per cent, also where most of a channel is less sure"""


@dataclass(frozen=True)
class Excess:
    """Per channel, the motors' (N) before the joints' (N m): RMS of what is left, and of noise alone."""

    rms: Array
    floor: Array

    @property
    def ratio(self) -> Array:
        """(C,)"""
        return self.rms / self.floor

    @property
    def energy(self) -> float:
        """Sum over channels of the variance beyond the floor, in units of the floor's."""
        return float(np.sum(np.maximum(self.ratio**2 - 1, 0.0)))

    @property
    def plain_energy(self) -> float:
        """The same beyond what is as good as noise."""
        return float(np.sum(np.maximum(self.ratio**2 - PLAIN**2, 0.0)))

    @property
    def plain(self) -> bool:
        """Whether some channel is above noise."""
        return bool(self.ratio.max() > PLAIN)


def excess(left: Sequence[Array], floor: Sequence[Sequence[Array]], unsure: Sequence[Array]) -> Excess:
    """Of recordings' residuals (C, S), and of their draws of noise; rows of which more is unsure count for less."""
    trust = trusted(floor, unsure)
    every = np.concatenate([t * r for t, r in zip(trust, left, strict=True)], axis=1)
    drawn = np.concatenate([t * d for t, draws in zip(trust, floor, strict=True) for d in draws], axis=1)
    return Excess(np.sqrt(np.mean(every**2, axis=1)), np.sqrt(np.mean(drawn**2, axis=1)))


def trusted(floor: Sequence[Sequence[Array]], unsure: Sequence[Array]) -> list[Array]:
    """Weights of every recording's rows (C, S), one and less: noise over that with what else is unsure. floor holds both.

    Noise is what makes the rows of the floor as loud as they should be, in the mean of (drawn^2 / (noise^2 + unsure)).
    """
    drawn = np.concatenate([np.mean(np.square(draws), axis=0) for draws in floor], axis=1)
    else_ = np.concatenate(list(unsure), axis=1)
    noise = np.mean(drawn, axis=1, keepdims=True)
    for _ in range(_ROUNDS):
        noise = noise * np.mean(drawn / (noise + else_), axis=1, keepdims=True)
    return [1 / np.sqrt(1 + u / noise) for u in unsure]
