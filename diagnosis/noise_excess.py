"""How far residuals stand above what noise alone leaves, channel by channel."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ABOVE_NOISE_RATIO = 1.25
"""times the noise floor's RMS: a channel up to there is as good as noise (docs/thresholds.md)"""

_WEIGHT_ROUNDS = 30
"""until noise is told to a per cent, also where most of a channel has much input variance"""


@dataclass(frozen=True)
class NoiseExcess:
    """Per channel, the motors' (N) before the joints' (N m): RMS of the residuals, and of noise alone."""

    rms: Array
    floor: Array

    @property
    def ratio(self) -> Array:
        """RMS over the noise floor, (C,)."""
        return self.rms / self.floor

    @property
    def _beyond(self) -> Array:
        """Of each channel, the variance beyond the floor, in units of the floor's, (C,)."""
        return np.maximum(self.ratio**2 - 1, 0.0)

    @property
    def energy(self) -> float:
        """Sum over channels of the variance beyond the floor, in units of the floor's."""
        return float(np.sum(self._beyond))

    def share_of(self, before: "NoiseExcess", channels: slice = slice(None)) -> float:
        """`energy` over what it was before, both in units of the lower of their floors; one where nothing stood above noise.

        Numbers of a wrong model may make many times as much of the same noise: in units of its own floor it seems near."""
        unit = np.minimum(self.floor, before.floor)
        now, then = (np.sum((e._beyond * (e.floor / unit) ** 2)[channels]) for e in (self, before))
        return float(now / then) if then else 1.0

    @property
    def energy_above_limit(self) -> float:
        """Sum over channels of the variance beyond what is as good as noise, in units of the floor's."""
        return float(np.sum(np.maximum(self.ratio**2 - ABOVE_NOISE_RATIO**2, 0.0)))

    @property
    def above_noise(self) -> bool:
        """Whether some channel is above noise."""
        return bool(self.ratio.max() > ABOVE_NOISE_RATIO)


def noise_excess(
    residuals: Sequence[Array], noise: Sequence[Sequence[Array]], input_variance: Sequence[Array]
) -> NoiseExcess:
    """Of recordings' residuals (C, S), and of their draws of noise; rows with more input variance count for less."""
    weights = row_weights(noise, input_variance)
    weighted = np.concatenate([w * r for w, r in zip(weights, residuals, strict=True)], axis=1)
    drawn = np.concatenate([w * d for w, draws in zip(weights, noise, strict=True) for d in draws], axis=1)
    return NoiseExcess(np.sqrt(np.mean(weighted**2, axis=1)), np.sqrt(np.mean(drawn**2, axis=1)))


def row_weights(noise: Sequence[Sequence[Array]], input_variance: Sequence[Array]) -> list[Array]:
    """Weights of every recording's rows (C, S), one and less: noise over noise and input variance; draws of noise hold both.

    A channel's noise is what makes its draws as loud as they should be: the mean of (draw^2 / (noise^2 + input variance)) is one.
    """
    drawn = np.concatenate([np.mean(np.square(draws), axis=0) for draws in noise], axis=1)
    variance = np.concatenate(list(input_variance), axis=1)
    level = np.mean(drawn, axis=1, keepdims=True)
    for _ in range(_WEIGHT_ROUNDS):
        level = level * np.mean(drawn / (level + variance), axis=1, keepdims=True)
    return [1 / np.sqrt(1 + v / level) for v in input_variance]
