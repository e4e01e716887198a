"""What the joints and the cables' tensions are asked to do: sums of sines, from rest to rest."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from samples.forward_arms.plant import Array, Plant
from samples.forward_arms.settings import Settings

_BANDS = {"rich": (0.1, 2.0), "slow": (0.04, 0.3)}
"""Hz"""
_TENSION_BAND = (0.04, 0.4)
"""Hz"""
_SINES = 10
_REST = 0.8
"""s, at the begin and at the end of the log"""
_RAMP = 1.5
"""s"""
FURTHEST = np.radians(120.0)
"""rad, that bars may turn against the base at the peaks of all joints"""


@dataclass(frozen=True)
class Asked:
    """Joint angles (N, T), rad, and tensions, N: (T,) what all cables' go about, or (M, T) each cable's."""

    alpha: Array
    about: Array


def _ramp(after: Array) -> Array:
    """From 0 to 1 within _RAMP, with speed and acceleration zero at both ends."""
    rise = np.clip(after / _RAMP, 0, 1)
    return rise**3 * (10 - 15 * rise + 6 * rise**2)


def envelope(settings: Settings, time: Array) -> Array:
    """(T,): from rest to rest."""
    return _ramp(time - _REST) * _ramp(settings.seconds - _REST - time)


def sines(settings: Settings, rng: np.random.Generator, rows: int, time: Array) -> Array:
    """Sums of sines between -1 and 1 in the band of the settings' motion, (rows, T)."""
    return _sines(rng, _BANDS[settings.motion], rows, time)(1.0)


def _sines(rng: np.random.Generator, band: tuple[float, float], rows: int, time: Array) -> Callable[[float], Array]:
    """`rows` sums of sines, their speeds alike at all frequencies, as a function of how much slower they are played: (rows, T)."""
    frequency = np.exp(rng.uniform(np.log(band[0]), np.log(band[1]), (rows, _SINES)))
    size = rng.uniform(0.5, 1.0, (rows, _SINES)) / frequency**0.7
    phase = rng.uniform(0, 2 * np.pi, (rows, _SINES))

    def at(slower: float) -> Array:
        out = np.zeros((rows, len(time)))
        for k in range(_SINES):
            out += size[:, k, None] * np.sin(2 * np.pi * frequency[:, k, None] / slower * time + phase[:, k, None])
        return out / np.abs(out).max(axis=1, keepdims=True)

    return at


def asked(
    settings: Settings, plant: Plant, rng: np.random.Generator, time: Array, speed: Callable[[Array], float]
) -> Asked:
    """At log times `time` (s); `speed` says how fast (rad/s) the fastest motor turns for joint angles (N, T)."""
    n = plant.N
    shape = envelope(settings, time)
    peak = np.radians(rng.uniform(*settings.peak_deg, (n, 1)))
    peak *= min(1.0, FURTHEST / peak.sum())
    if settings.joint_shares is not None:
        peak *= np.array(settings.joint_shares)[:, None]
    joints = _sines(rng, _BANDS[settings.motion], n, time)
    slower, alpha = 1.0, shape * peak * joints(1.0)
    for _ in range(4):
        too_fast = speed(alpha) / settings.motor_speed
        if too_fast <= 1:
            break
        slower *= 1.02 * too_fast
        alpha = shape * peak * joints(slower)
    low, high = settings.tension_range
    rest = float(np.clip(1.1 * np.mean(plant.stiffness * plant.x0), low, high))
    centre = float(np.clip(rng.uniform(*settings.pretension), low, high))
    swing = 0.7 * min(centre - low, high - centre) if settings.tension == "rich" else 0.0
    about = rest + shape * (centre - rest + swing * _sines(rng, _TENSION_BAND, 1, time)(1.0)[0])
    return Asked(alpha, about)
