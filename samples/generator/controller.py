"""The controller that drove the recordings: it knows motor angles only, and holds each command for one period."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from samples.generator.motion import RATE_HZ, Motion
from samples.generator.motors import SHARPNESS
from samples.generator.routes import lengths
from samples.generator.taut_string import Array

_STIFFNESS = 9000.0
"""N/m on the cable, of the position loop"""
_DAMPING = 700.0
"""N s/m on the cable"""
_SPEED_FILTER_HZ = 40.0
"""encoder counts make steps of 1.5 rad/s at 500 Hz"""
_FRICTION_GUESS = 15.0
"""N, for every gear"""
_CABLE_GUESS = (10000.0, 9000.0, 8000.0, 5500.0)
"""N/m, to turn tensions into motor angles"""
_COMMAND_LIMITS = (0.0, 160.0)
_COMMAND_STEP = 0.001
"""N; the drive takes whole steps"""


@dataclass(frozen=True)
class Plan:
    """What each motor is to do, sampled at the controller's rate; all of shape (T, M)."""

    theta: Array
    """rad"""
    theta_d: Array
    """rad/s"""
    force: Array
    """tension, friction and inertia, N"""


def plan(neck: dict[str, Any], motion: Motion) -> Plan:
    """Motor angles that give the motion's lengths and tensions with linear cables of the guessed stiffness."""
    motors, cables = neck["motors"], neck["cables"]
    drum = np.array([m["rd"] / m["R"] for m in motors])
    inertia = np.array([m["Ia"] for m in motors])
    x0 = np.array([c.get("x0", 0.0) for c in cables])
    k = np.resize(_CABLE_GUESS, len(cables))
    unrolled = lengths(neck, motion.alpha) - lengths(neck, np.zeros_like(motion.alpha[0]))
    theta = CubicSpline(motion.time, (motion.tension / k - unrolled - x0) / drum, bc_type="clamped")
    theta_d = theta(motion.time, 1)
    force = motion.tension + _FRICTION_GUESS * (2 / np.pi) * np.arctan(SHARPNESS * theta_d)
    return Plan(theta(motion.time), theta_d, force + inertia / drum * theta(motion.time, 2))


class Controller:
    """Feed-forward and a position loop on every motor. Stateful: it filters the speed that it differentiates itself."""

    def __init__(self, neck: dict[str, Any], planned: Plan) -> None:
        self.plan = planned
        self.drum = np.array([m["rd"] / m["R"] for m in neck["motors"]])
        self._last: Array | None = None
        self._speed = np.zeros(len(self.drum))
        self._smoothing = 1 - np.exp(-2 * np.pi * _SPEED_FILTER_HZ / RATE_HZ)

    def command(self, sample: int, theta: Array) -> Array:
        """Force commands, shape (M,), N, from measured motor angles, shape (M,), rad; the plan's ends are held."""
        raw = np.zeros_like(theta) if self._last is None else (theta - self._last) * RATE_HZ
        self._last = theta
        self._speed = self._speed + self._smoothing * (raw - self._speed)
        i = min(max(sample, 0), len(self.plan.theta) - 1)
        wanted = self.plan
        pull = _STIFFNESS * (wanted.theta[i] - theta) + _DAMPING * (wanted.theta_d[i] - self._speed)
        f = wanted.force[i] + self.drum * pull
        return np.round(np.clip(f, *_COMMAND_LIMITS) / _COMMAND_STEP) * _COMMAND_STEP
