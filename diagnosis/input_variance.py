"""What the rounding of counts leaves unknown of motors' forces: little, but for rows in which a motor turns round.

Friction is known as well as the speed is. Where a motor is about to turn round, friction changes by newtons within one radian per
second: the error of the speed, which motor_speeds.py leaves, becomes one of the force for a few rows.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.encoder_steps import measured_steps
from identification.residuals import motor_motion
from identification.signals import Signals
from mechanism.machine import Machine
from mechanism.typical_load import typical_load

Array = NDArray[np.float64]

_HERTZ = np.arange(1.25, 30.0, 2.5)
"""frequencies that stand for the speed's error: as far apart as the equations' filter can tell them"""
_LEAST_FORCE_STEP = 1e-3
"""of an arm's typical load (docs/thresholds.md)"""
_MAX_INERTIA_HZ = 30.0
"""up to which motor angles are followed, and rounding shows in the acceleration"""


@dataclass(frozen=True)
class FrictionSlopes:
    """Change of friction with the motors' motion, in the mean over each row, (T, M)."""

    by_speed: Array
    """N s/rad"""
    by_path: Array
    """by the angle, as bristles bend, N/rad"""

    @classmethod
    def of(cls, machine: Machine, s: Signals, tension: Array) -> "FrictionSlopes":
        """On a recording; tension: (T, M), N, under which motors rub."""
        at = motor_motion(s, machine, tension)
        return cls(machine.friction_slope(at).mean(axis=0), machine.friction_by_path(at).mean(axis=0))


def input_variance(s: Signals, slopes: FrictionSlopes) -> Array:
    """Variance of every channel's rows by the error of friction, (C, S), N^2 and (N m)^2."""
    density = s.speeds.error_density(_HERTZ, s.step) * np.gradient(_HERTZ)[:, None]
    lever = (s.Z[s.low_pass.kept] ** 2).transpose(1, 2, 0)
    # friction follows the angle by a quarter of a wave later than the speed
    cosines, sines = s.low_pass.of_waves(slopes.by_speed.T, _HERTZ * s.step)
    if slopes.by_path.any():
        by_path = s.low_pass.of_waves(slopes.by_path.T, _HERTZ * s.step) / (2 * np.pi * _HERTZ[:, None])
        cosines, sines = cosines + by_path[1], sines - by_path[0]
    motor = np.einsum("km,mks->ms", density, cosines**2 + sines**2)
    return np.concatenate([motor, np.einsum("nms,ms->ns", lever, motor)])


def force_steps(data: DataSet) -> Array:
    """In which steps forces were logged, (M,), N: zero where finer than what counts beside an arm's load, or not told."""
    steps = measured_steps(data.log.matrix("f"))
    if len(steps) != data.arm.M:
        return np.zeros(data.arm.M)
    return np.where(steps > _LEAST_FORCE_STEP * typical_load(data.arm), steps, 0.0)


def residuals_of_rounding(s: Signals, logged_f: Array, steps: Array, rng: np.random.Generator) -> Array:
    """Residuals, (C, S), by one draw of what rounding to `steps` (M,), N, takes from forces like the logged ones, (T, M), N."""
    error = np.zeros_like(s.f)
    for j in np.flatnonzero(steps):
        error[:, j] = _rounding_error(logged_f[:, j], float(steps[j]), rng)
    error[1:] = (error[1:] + error[:-1]) / 2  # a force counts by its mean over the row, as `signals_of` takes it
    return residuals_of_friction(s, error)


def _rounding_error(logged: Array, step: float, rng: np.random.Generator) -> Array:
    """Of a course that is rounded to much the same as the logged one, (T,).

    Through the middles of the stretches in which that stays; where it changes at every row, anywhere within a step of it."""
    begin = np.flatnonzero(np.diff(logged, prepend=np.nan) != 0)
    end = np.append(begin[1:], len(logged))
    within = np.where(end - begin == 1, step * rng.uniform(-0.5, 0.5, len(begin)), 0.0)
    course = np.interp(np.arange(len(logged)), (begin + end - 1) / 2, logged[begin] + within)
    course += step * rng.uniform(-0.5, 0.5)
    return step * np.rint(course / step) - course


def residuals_of_inertia(s: Signals, rng: np.random.Generator) -> Array:
    """Residuals, (C, S), by one draw of the rounding of counts in the motors' inertia."""
    rows, motors = s.theta.shape
    hertz = np.fft.rfftfreq(rows, s.step)
    rounding = np.fft.rfft(s.speeds.rounding * rng.normal(size=(rows, motors)), axis=0)
    followed = (hertz < _MAX_INERTIA_HZ)[:, None] * rounding
    acceleration = np.fft.irfft(-((2 * np.pi * hertz[:, None]) ** 2) * followed, rows, axis=0)
    return residuals_of_friction(s, s.arm.motor_inertia / s.arm.drum * acceleration)


def residuals_of_friction(s: Signals, force: Array) -> Array:
    """Residuals, (C, S), where motors lose a force (T, M), N, that the laws do not say."""
    torque = np.einsum("ijt,jt->it", s.levers, force.T)
    return -np.concatenate([s.low_pass(force.T), s.low_pass(torque)])
