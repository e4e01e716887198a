"""What the arm is asked to do: sums of sines in every joint, and tensions that rise and fall on their own."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from samples.generator.statics import hold
from samples.generator.taut_string import Array

_TONES = 6
LEVEL_N = (62.0, 24.0)
"""mean and swing of the tension level"""
_TENSION_LIMITS_N = (15.0, 120.0)
_RAMP_S = 1.0
_ROWS_APART = 10
RATE_HZ = 500
"""of the controller, which reads the motion"""


@dataclass(frozen=True)
class Motion:
    """A motion that starts and ends at rest in the straight pose, sampled at the controller's rate."""

    time: Array
    """shape (T,), s from its start"""
    alpha: Array
    """shape (T, N), rad"""
    tension: Array
    """that holds the described arm there, shape (T, M), N"""


def ramp(time: Array, duration: float) -> Array:
    """0 at both ends, 1 between, with two continuous derivatives, shape (T,)."""
    u = np.clip(np.minimum(time, duration - time) / _RAMP_S, 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def _sum_of_sines(time: Array, rng: np.random.Generator, hertz: tuple[float, float]) -> Array:
    """One tone in each of equal (logarithmic) bands, so that no two signals share their frequencies; peak 1."""
    edges = np.geomspace(*hertz, _TONES + 1)
    tones = rng.uniform(edges[:-1], edges[1:])
    phase = rng.uniform(0, 2 * np.pi, _TONES)
    amplitude = tones**-0.3  # a little less of what costs most acceleration
    signal = amplitude @ np.sin(2 * np.pi * tones[:, None] * time + phase[:, None])
    return signal / np.abs(signal).max()


def exciting(
    neck: dict[str, Any],
    duration: float,
    rng: np.random.Generator,
    hertz: tuple[float, float] = (0.1, 1.2),
    peak_deg: tuple[float, float] = (25.0, 32.0),
    level_n: tuple[float, float] = LEVEL_N,
) -> Motion:
    """A persistently exciting motion; drawn again until every tension stays within its limits.

    level_n: mean and swing of the tension level, N.
    """
    time = np.arange(round(duration * RATE_HZ) + 1) / RATE_HZ
    on = ramp(time, duration)
    n, m = len(neck["mechanisms"]), len(neck["cables"])
    for _ in range(200):
        peaks = np.radians(rng.uniform(*peak_deg, n))
        alpha = np.stack([on * p * _sum_of_sines(time, rng, hertz) for p in peaks], axis=-1)
        level = level_n[0] + level_n[1] * on * _sum_of_sines(time, rng, hertz)
        levels = np.repeat(level[:, None], m, axis=1)
        # most that are not good are known by a few of their rows
        if _within_limits(hold(neck, alpha[::_ROWS_APART], levels[::_ROWS_APART]).tension):
            tension = hold(neck, alpha, levels).tension
            if _within_limits(tension):
                return Motion(time, alpha, tension)
    raise ValueError(f"no motion within {_TENSION_LIMITS_N} N was found")


def _within_limits(tension: Array) -> bool:
    return bool(_TENSION_LIMITS_N[0] < tension.min() and tension.max() < _TENSION_LIMITS_N[1])


def with_rest(motion: Motion, before: int, after: int) -> Motion:
    """The motion with that many samples of rest before and after it."""
    time = np.arange(before + len(motion.time) + after) / RATE_HZ
    around = ((before, after), (0, 0))
    return Motion(time, np.pad(motion.alpha, around, mode="edge"), np.pad(motion.tension, around, mode="edge"))
