"""The controller: motor trajectories by inverse kinematics, tensions by inverse dynamics, and PD on counted angles."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from samples.forward_arms.cables import lengths, levers
from samples.forward_arms.dynamics import equations
from samples.forward_arms.given_motion import GivenMotion
from samples.forward_arms.joints import folded, placed
from samples.forward_arms.motion import asked
from samples.forward_arms.plant import ROW, Array, Plant, side_by_side
from samples.forward_arms.pulled import pulled
from samples.forward_arms.settings import Settings
from samples.forward_arms.symmetric import factor, solve

_BANDWIDTH = (4.0, 7.0)
"""Hz, of the position loop with the motor's own inertia"""
_DAMPING = 0.8
_SPEED_FILTER = 30.0
"""Hz, of the low pass behind the difference of counted angles"""
_TURNING = 3.0
"""rad/s, within which the friction that is fed forward turns over"""
_ROUNDING = 0.05
"""s, over which tensions are smoothed: where a cable meets its least tension, motors would be asked to jerk"""
_PROJECTIONS = 60


@dataclass(frozen=True)
class Plan:
    """Of one recording."""

    theta: Array
    """(M,), rad, in the first rest"""
    drive: Array
    """(T, M), N: all of the command that does not depend on what the encoders say"""
    stiffness: Array
    """(M,), N/rad"""
    damping: Array
    """(M,), N s/rad"""


def planned(
    settings: Settings, drawing: Plant, rng: np.random.Generator, time: Array, given: GivenMotion | None = None
) -> Plan:
    """At the rows' log times (s), with the numbers of the drawing: the controller knows no others.

    given: the motion, in the place of one that is drawn; its tensions give way where the drawing needs others for its angles.
    """
    plant = side_by_side([drawing])
    travel = plant.travel

    def speed(alpha: Array) -> float:
        alpha_d = np.gradient(alpha, ROW, axis=1)
        run = np.einsum("imt,it->mt", levers(plant, folded(plant, alpha)), alpha_d) / travel
        return float(np.abs(run).max())

    if settings.motion_of == "tensions" and given is None:
        alpha, t = pulled(settings, drawing, rng, time)
        fold = folded(plant, alpha)
    else:
        wish = given.asked(time) if given else asked(settings, drawing, rng, time, speed)
        alpha = wish.alpha
        alpha_d = np.gradient(alpha, ROW, axis=1)
        fold = folded(plant, alpha)
        eq = equations(plant, fold, placed(fold), alpha_d)
        torque = np.einsum("ijt,jt->it", eq.mass, np.gradient(alpha_d, ROW, axis=1)) + eq.rest
        t = _tensions(levers(plant, fold), torque, wish.about, settings.tension_range)
        t = gaussian_filter1d(t, _ROUNDING / ROW, axis=1, mode="nearest")
    straight = np.zeros((plant.N, 1))
    wound = lengths(plant, fold, alpha) - lengths(plant, folded(plant, straight), straight)
    theta = (t / plant.stiffness - plant.x0 - wound) / travel
    theta_d = np.gradient(theta, ROW, axis=1)
    inertia = plant.motor_inertia / travel
    bandwidth = 2 * np.pi * rng.uniform(*_BANDWIDTH)
    kp, kd = inertia * bandwidth**2, 2 * _DAMPING * inertia * bandwidth
    forward = t + inertia * np.gradient(theta_d, ROW, axis=1) + plant.viscous * theta_d
    forward += settings.friction_compensation * plant.dry * np.tanh(theta_d / _TURNING)
    drive = forward + kp * theta + kd * theta_d
    return Plan(theta[:, 0], np.ascontiguousarray(drive.T), kp[:, 0], kd[:, 0])


def _tensions(Z: Array, torque: Array, about: Array, within: tuple[float, float]) -> Array:
    """(M, T): near `about`, Z t = torque as far as the cables can, within limits."""
    square = factor(np.einsum("imt,jmt->ijt", Z, Z) + 1e-9 * np.eye(len(Z))[:, :, None])
    t = np.broadcast_to(about, Z.shape[1:]).copy()
    for _ in range(_PROJECTIONS):
        t += np.einsum("imt,it->mt", Z, solve(square, torque - np.einsum("imt,mt->it", Z, t)))
        if np.all((t >= within[0]) & (t <= within[1])):
            break
        np.clip(t, *within, out=t)
    return t


class Loop:
    """The part that runs row by row, of many recordings: feeds counted angles back."""

    def __init__(self, plans: list[Plan]) -> None:
        self._drive = np.stack([p.drive for p in plans], axis=-1)
        self._kp, self._kd = (np.stack([getattr(p, k) for p in plans], axis=-1) for k in ("stiffness", "damping"))
        self._last = np.stack([p.theta for p in plans], axis=-1)
        self._speed = np.zeros_like(self._last)
        self._share = 1 - np.exp(-2 * np.pi * _SPEED_FILTER * ROW)

    def command(self, row: int, counted: Array) -> Array:
        """(M, B), N at the cable."""
        self._speed += self._share * ((counted - self._last) / ROW - self._speed)
        self._last = counted
        return self._drive[row] - self._kp * counted - self._kd * self._speed
