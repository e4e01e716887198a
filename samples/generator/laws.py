"""What cables, gears and joints may do: laws for recordings whose motion is given.

A stretch law turns tensions, shape (T, M), N, sampled every `step` s, into elongations of that shape, m. A friction law
turns what motors do into the force that friction takes from the command, N at the cable, (T, M).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter
from scipy.special import exprel

from samples.generator.motors import SHARPNESS
from samples.generator.taut_string import Array


@dataclass(frozen=True)
class Running:
    """What friction may depend on, at every fine step; rows T, mechanisms N, motors M."""

    time: Array
    """(T,), s since the log began"""
    alpha: Array
    """(T, N), rad"""
    theta: Array
    """motor side, (T, M), rad"""
    theta_d: Array
    """rad/s"""
    tension: Array
    """N"""


Stretch = Callable[[Array, float], Array]
Friction = Callable[[Running], Array]

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


def maxwell_slip(k: Array, ca: Array, stiffness: Array, travel: Array) -> Stretch:
    """Beside a spring k and a damper ca, both (M,), elements that stick, give way by `travel` (m) and slip; both (E, M), N/m.

    (k + sum of stiffnesses) x + ca x' = t + sum of stiffness * play(x) is solved like `damped`.
    """
    steepest = k + stiffness.sum(axis=0)

    def stretch(tension: Array, step: float) -> Array:
        x = tension / steepest
        for _ in range(_ROUNDS):
            before = x
            free = sum(s * play(x, h) for s, h in zip(stiffness, travel, strict=True))
            x = _first_order(tension + free, steepest, ca, step)
            if np.abs(x - before).max() < _EXACT_M:
                return x
        raise ValueError("no elongation was found that the elements agree on")

    return stretch


def toe(k: Array, growth: Array) -> Spring:
    """t = k (exp(growth x) - 1) / growth: soft at first; k N/m, growth 1/m, both (M,)."""
    return lambda x: k * x * exprel(growth * x)


def cubic(k: Array, k3: Array) -> Spring:
    """t = k x + k3 x^3; k N/m, k3 N/m^3, both (M,)."""
    return lambda x: k * x + k3 * x**3


def with_creep(law: Stretch, compliance: Array, tau: float) -> Stretch:
    """In series with a Kelvin element: `compliance` (M,), m/N, approached with the time constant tau, s."""

    def stretch(tension: Array, step: float) -> Array:
        m = tension.shape[1]
        return law(tension, step) + compliance * _first_order(tension, np.ones(m), np.full(m, tau), step)

    return stretch


def bending(force: Array, angle: Array, sharpness: float) -> Friction:
    """For dry friction of `force` (M,), N: elements that share it, stick, give way by `angle` (E, 1), rad, then slip."""

    def law(at: Running) -> Array:
        held = [(at.theta - play(at.theta, np.broadcast_to(a, at.theta.shape[1:]))) / a for a in angle]
        return force * (np.mean(held, axis=0) - way(at.theta_d, sharpness))

    return law


def dry_and_viscous(fs: Array, fv: Array, sharpness: float = SHARPNESS) -> Friction:
    """fs (N) with a smooth change of sign, and fv (N s/rad), both (M,)."""
    return lambda at: fs * way(at.theta_d, sharpness) + fv * at.theta_d


def way(speed: Array, sharpness: float) -> Array:
    """-1 or 1 with the sign of speed, and smooth between; sharpness in 1/(unit of speed)."""
    return 2 / np.pi * np.arctan(sharpness * speed)


def fading(fb: Array, vs: float, sharpness: float) -> Friction:
    """Friction fb (M,), N, around rest that fades with the speed like a Lorentz curve of width vs, rad/s."""
    return lambda at: fb * way(at.theta_d, sharpness) / (1 + (at.theta_d / vs) ** 2)


def capstan(mu: float, wrap: Callable[[Array], Array], sharpness: float) -> Friction:
    """What pulleys take from a cable that runs over them: t (exp(mu wrap) - 1), with the way it runs; wrap(alpha) (T, M), rad."""
    return lambda at: at.tension * np.expm1(mu * wrap(at.alpha) * way(at.theta_d, sharpness))


def ahead(values: Array, step: float, by: float) -> Array:
    """A series (T, M) sampled every `step` s, read `by` s later (or earlier, if negative); its ends are held."""
    time = np.arange(len(values)) * step
    return np.stack([np.interp(time + by, time, column) for column in values.T], axis=-1)


def play(values: Array, half: Array) -> Array:
    """What follows `values` (T, M) through a play of `half` (M,) to either side; in its middle at first."""
    out = np.empty_like(values)
    for j, column in enumerate(values.T):
        moving = np.flatnonzero(np.diff(column))
        up = column[moving + 1] > column[moving]
        starts, y = np.concatenate([[0], moving[1:][up[1:] != up[:-1]]]), column[0]
        kept = np.empty(len(starts))
        for i, row in enumerate(starts):  # between two turns the play is either crossed or pushed on
            y = min(max(y, column[row] - half[j]), column[row] + half[j])
            kept[i] = y
        held = np.repeat(kept, np.diff(starts, append=len(column)))
        out[:, j] = np.clip(held, column - half[j], column + half[j])
    return out
