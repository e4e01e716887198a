"""Motions of arms whose cables cannot choose how the joints bend: tensions are asked for, and the joints go where they rest.

With fewer cables than joints and one, most motions of the joints need a cable that pushes.
"""

import numpy as np
from scipy.interpolate import CubicSpline

from samples.forward_arms.cables import levers
from samples.forward_arms.dynamics import equations
from samples.forward_arms.joints import folded, placed
from samples.forward_arms.motion import FURTHEST, envelope, sines
from samples.forward_arms.plant import Array, Plant, side_by_side
from samples.forward_arms.settings import Settings

_EVERY = 10
"""rows from one pose that is solved for to the next"""
_NEWTON_STEPS = 60
_LONGEST_STEP = 0.1
"""rad"""
_SLOPE_STEP = 1e-5
"""rad"""
_HALVINGS = 8
"""of the tensions' range, until no joint bends further than is asked"""


def pulled(settings: Settings, drawing: Plant, rng: np.random.Generator, time: Array) -> tuple[Array, Array]:
    """Joint angles (N, T), rad, and tensions (M, T), N, that hold them at rest; at log times `time` (s)."""
    plant = side_by_side([drawing])
    low, high = settings.tension_range
    wish = envelope(settings, time) * (1 + sines(settings, rng, plant.M, time)) / 2
    peak = np.radians(rng.uniform(*settings.peak_deg))
    coarse = np.unique(np.append(np.arange(0, len(time), _EVERY), len(time) - 1))
    for _ in range(_HALVINGS):
        tension = low + (high - low) * wish
        alpha = _resting(plant, tension[:, coarse])
        if np.abs(alpha).max() <= peak and np.abs(np.cumsum(alpha, axis=0)).max() <= FURTHEST:
            return CubicSpline(time[coarse], alpha, axis=1)(time), tension
        high = low + (high - low) / 2
    raise ValueError("no tension of this range holds the arm near the straight pose")


def _resting(plant: Plant, tension: Array) -> Array:
    """Angles (N, T), rad, at which tensions (M, T), N, balance gravity and springs."""
    alpha = np.zeros((plant.N, tension.shape[1]))
    for _ in range(_NEWTON_STEPS):
        slope = np.empty((plant.N, plant.N, tension.shape[1]))
        torque = _unbalanced(plant, alpha, tension)
        for i, joint in enumerate(np.eye(plant.N)[:, :, None]):
            slope[:, i] = (_unbalanced(plant, alpha + _SLOPE_STEP * joint, tension) - torque) / _SLOPE_STEP
        step = -np.linalg.solve(np.moveaxis(slope, -1, 0), torque.T[..., None])[..., 0].T
        alpha = alpha + np.clip(step, -_LONGEST_STEP, _LONGEST_STEP)
        alpha = np.clip(alpha, -FURTHEST, FURTHEST)
    return alpha


def _unbalanced(plant: Plant, alpha: Array, tension: Array) -> Array:
    """What tensions turn the joints by beyond gravity and springs, (N, T), N m."""
    fold = folded(plant, alpha)
    rest = equations(plant, fold, placed(fold), np.zeros_like(alpha)).rest
    return np.einsum("imt,mt->it", levers(plant, fold), tension) - rest
