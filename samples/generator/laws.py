"""What cables, gears and joints may do: laws for recordings whose motion is given.

A stretch law turns tensions, shape (T, M), N, sampled every `step` s, into elongations of that shape, m. A friction law
turns motor speeds (rad/s) and tensions (N), both (T, M), into the force that friction takes from the command, N at the cable.
"""

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from samples.generator.motors import SHARPNESS
from samples.generator.taut_string import Array

Stretch = Callable[[Array, float], Array]
Friction = Callable[[Array, Array], Array]

Spring = Callable[[Array], Array]
"""elongation (T, M), m -> tension, N"""

_ROUNDS = 400
_EXACT_M = 1e-13


def linear(k: Array, ca: Array) -> Stretch:
    """A spring k (N/m) and a damper ca (N s/m) side by side, both (M,)."""
    return lambda tension, step: _first_order(tension, k, ca, step)


def damped(spring: Spring, steepest: Array, ca: Array) -> Stretch:
    """A damper ca (N s/m), (M,), beside a spring that is nowhere stiffer than `steepest` (N/m), (M,).

    steepest x + ca x' = t - (spring(x) - steepest x) is solved for the left side until the right one stays.
    """

    def stretch(tension: Array, step: float) -> Array:
        x = tension / steepest
        for _ in range(_ROUNDS):
            before = x
            x = _first_order(tension - spring(x) + steepest * x, steepest, ca, step)
            if np.abs(x - before).max() < _EXACT_M:
                return x
        raise ValueError("the spring is stiffer than said, or too soft in places")

    return stretch


def _first_order(u: Array, k: Array, ca: Array, step: float) -> Array:
    """x of k x + ca x' = u, at rest at first, u straight between samples; (T, M)."""
    out = np.empty_like(u)
    for j, (stiffness, damping) in enumerate(zip(k, ca, strict=True)):
        tau = damping / stiffness / step
        decay = np.exp(-1 / tau) if tau else 0.0
        late = 1 - tau * (1 - decay)
        weights = np.array([late, 1 - decay - late]) / stiffness
        state = u[0, j] / stiffness - weights[0] * u[0, j]
        out[:, j], _ = lfilter(weights, [1, -decay], u[:, j], zi=[state])
    return out


def toe(k: Array, growth: Array) -> Spring:
    """t = k (exp(growth x) - 1) / growth: soft at first; k N/m, growth 1/m, both (M,)."""
    return lambda x: k * np.expm1(growth * x) / growth


def cubic(k: Array, k3: Array) -> Spring:
    """t = k x + k3 x^3; k N/m, k3 N/m^3, both (M,)."""
    return lambda x: k * x + k3 * x**3


def with_creep(law: Stretch, compliance: Array, tau: float) -> Stretch:
    """In series with a Kelvin element: `compliance` (M,), m/N, approached with the time constant tau, s."""

    def stretch(tension: Array, step: float) -> Array:
        m = tension.shape[1]
        return law(tension, step) + compliance * _first_order(tension, np.ones(m), np.full(m, tau), step)

    return stretch


def dry_and_viscous(fs: Array, fv: Array) -> Friction:
    """fs (N) with a smooth change of sign, and fv (N s/rad), both (M,)."""
    return lambda theta_d, _: fs * (2 / np.pi) * np.arctan(SHARPNESS * theta_d) + fv * theta_d
