"""Motor speeds within the rows of a log, as motor_speeds.py estimates them."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mechanism.laws.law import KeptShares

Array = NDArray[np.float64]

SMOOTHER_ORDER = 8
"""the smoother lets through 1 / (1 + (frequency / cutoff)^8) of rounding's amplitude"""


UNREFINED_HZ = 30.0
"""Hz: up to which a state's motor angles follow the counts"""


@dataclass(frozen=True)
class HalfRowSpeeds:
    """Speeds of the motors, and what the rounding of counts leaves uncertain of them."""

    mean: Array
    """mean theta' over the half row before and after each row, (2, T, M), rad/s"""
    cutoff: Array
    """of the smoother for each motor, (M,), Hz"""
    rounding: Array
    """standard deviation of each motor's counted angle, (M,), rad"""
    draw_errors: Callable[[], Array] | None = None
    """draws the error of `mean` some times, (D, 2, T, M), rad/s: as long as the speeds themselves take"""

    @cached_property
    def errors(self) -> Array:
        """Draws of the error of `mean`, (D, 2, T, M), rad/s; D is zero where none can be drawn."""
        return self.draw_errors() if self.draw_errors else np.zeros((0, *self.mean.shape))

    @cached_property
    def kept_shares(self) -> KeptShares:
        """Dry friction's shares at these speeds that were asked for of late."""
        return []

    @cached_property
    def path_memories(self) -> dict[Hashable, Array]:
        """What friction remembers of this path, by the numbers of its laws: whoever computes it keeps it here."""
        return {}

    def path(self, step: float) -> Array:
        """Angles at the ends of the half rows, (2 T + 1, M), rad, from zero on, of rows `step` s apart."""
        speeds = self.mean.swapaxes(0, 1).reshape(-1, self.mean.shape[2])
        return np.concatenate([np.zeros_like(speeds[:1]), np.cumsum(speeds, axis=0) * step / 2])

    def error_density(self, hertz: Array, step: float) -> Array:
        """One-sided density of the speeds' error, (K, M), (rad/s)^2/Hz, at frequencies (K,), of rows `step` s apart."""
        return (
            smoother_response(hertz[:, None], self.cutoff)
            * (2 * np.pi * hertz[:, None]) ** 2
            * 2
            * step
            * self.rounding**2
        )


def smoother_response(hertz: Array, cutoff: Array) -> Array:
    """Share of rounding's amplitude that the smoother lets through, at frequencies and for cutoffs that broadcast."""
    return 1 / (1 + (hertz / cutoff) ** SMOOTHER_ORDER)


def unrefined_speeds(theta_d: Array, count: Array) -> HalfRowSpeeds:
    """Speeds at the rows (T, M), rad/s, in place of those within the rows; count: of each encoder, (M,), rad."""
    return HalfRowSpeeds(
        np.stack([theta_d.T, theta_d.T]).swapaxes(1, 2),
        np.full(len(count), UNREFINED_HZ),
        count / np.sqrt(12),
    )
