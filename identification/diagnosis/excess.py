"""How far residuals stand above what noise alone leaves, channel by channel."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PLAIN = 1.25
"""times the floor: below, a channel is as good as noise. Forces are rounded, friction turns in its own way, a drawing's per cents
do not add up in a straight line: without any effect the worst channel of three arms came to 1.03, 1.07 and 1.12"""


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
    def plain(self) -> bool:
        """Whether some channel is above noise."""
        return bool(self.ratio.max() > PLAIN)


def excess(left: Sequence[Array], floor: Sequence[Sequence[Array]]) -> Excess:
    """Of recordings' residuals (C, S), and of their draws of noise."""
    every = np.concatenate(left, axis=1)
    drawn = np.concatenate([d for draws in floor for d in draws], axis=1)
    return Excess(np.sqrt(np.mean(every**2, axis=1)), np.sqrt(np.mean(drawn**2, axis=1)))
