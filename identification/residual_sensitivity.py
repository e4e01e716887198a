"""By how much the residuals change with the arm's description, or with an error of the angles.

Computed at the rows that the filter keeps: geometry, loads and elongations are slow, only the motors' forces and accelerations need
the filter. Angles are the smoothed state's: with vision's noise in them the changes would correlate with the residuals.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import pull_memory
from identification.decimation import CUTOFF_HZ
from identification.residuals import friction_by_tension, law_forces, remembered_motion
from identification.signals import Signals
from mechanism.arm import Arm
from mechanism.cable_lengths import geometry_of_poses, lengths
from mechanism.dynamics import terms
from mechanism.elasticity import elongation_rate
from mechanism.friction import dry
from mechanism.laws import CableMotion, JointMotion
from mechanism.machine import Machine

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AngleError:
    """What the true angles are beyond those measured, each (S, N) or (N,), rad, with derivatives."""

    alpha: Array
    alpha_d: Array | float = 0.0
    alpha_dd: Array | float = 0.0


_NO_ERROR = AngleError(np.zeros(1))


_SHAPE = ("L", "b", "r")
"""of an arm: what its cables' ways depend on"""
_BODY = ("L", "b", "diagonal_mass", "diagonal_inertia", "top_mass", "top_inertia", "top_com", "gravity")
"""and, with the springs, what its load does"""
_SPRINGS = ("spring_stiffness", "spring_free_length")


class ResidualSensitivity:
    """The residuals of one recording with its laws, to be computed again with another arm or with other angles.

    laws, values, x0, delay, z: as `law_forces` has them."""

    def __init__(
        self,
        s: Signals,
        laws: tuple[str, ...],
        values: Mapping[str, Array],
        x0: Array,
        delay: float,
        z: Array | None = None,
    ) -> None:
        kept = s.low_pass.kept
        self._arm, self._kept = s.arm, kept
        self._low_pass, self._step = s.low_pass, s.step
        self._values, self._x0, self._laws = values, x0, laws
        machine = Machine(s.arm, laws, values)
        if z is None:
            z = pull_memory(machine, remembered_motion(s, self._x0), s.step)
        forces = law_forces(s, laws, values, x0, delay, z)
        self._drive = s.low_pass(forces.drive.T).T
        self._memory = z[kept]
        self._alpha = s.alpha[kept], s.alpha_d[kept], s.alpha_dd[kept]
        self._jerk = np.gradient(s.alpha_dd, s.step, axis=0)[kept]
        self._theta = s.theta[kept], s.theta_d[kept]
        self._since_began = s.since_began[kept][:, None]
        # where a cable rubs on its pulleys, a newton at the motor is not one at the arm
        felt = s.theta_dd / (1 + friction_by_tension(s, machine, forces.pull))
        self._theta_dd, self._felt_theta_dd = s.low_pass(s.theta_dd.T).T, s.low_pass(felt.T).T
        self._ways = _Ways.of(s.arm, self._alpha[0])
        self._load = _load(s.arm, *self._alpha)
        self._residual_0 = self._residual(s.arm, _NO_ERROR)

    def error_of_lag(self, lag: Array | float) -> AngleError:
        """The error of angles from frames that show what the arm did `lag` (S,), s, later than their stamps say."""
        lag = np.broadcast_to(lag, len(self._kept))[:, None]
        _, alpha_d, alpha_dd = self._alpha
        return AngleError(lag * alpha_d, lag * alpha_dd, lag * self._jerk)

    def errors_by_cables(self, s: Signals) -> list[Array]:
        """Errors of the angles, each (S, N), rad, by what is uncertain of the law of the cables that they follow from."""
        if s.elongation_errors is None:
            return []
        tension = self._drive - self._arm.motor_inertia / self._arm.drum * self._theta_dd
        command, friction = s.low_pass(s.f.T).T, s.low_pass(dry(s.speeds.mean).mean(axis=0).T).T
        return s.elongation_errors.of_angles(self._ways.Z, tension, command, friction, self._theta[1])

    def residual_change(self, arm: Arm | None = None, angle_error: AngleError = _NO_ERROR) -> Array:
        """Change of the residuals with another arm or other angles, (C, S)."""
        return self._residual(arm or self._arm, angle_error) - self._residual_0

    def _residual(self, arm: Arm, error: AngleError) -> Array:
        theta, theta_d = self._theta
        errors = (error.alpha, error.alpha_d, error.alpha_dd)
        alpha, alpha_d, alpha_dd = (measured + e for measured, e in zip(self._alpha, errors, strict=True))
        as_measured = error is _NO_ERROR
        ways = self._ways if as_measured and _alike(arm, self._arm, _SHAPE) else _Ways.of(arm, alpha)
        same_load = as_measured and _alike(arm, self._arm, (*_BODY, *_SPRINGS))
        load = self._load if same_load else _load(arm, alpha, alpha_d, alpha_dd)
        x_d = elongation_rate(arm, ways.Z, alpha_d, theta_d)
        # the fitted x0 is beyond that of the signals' arm, and another arm may have another one
        x = ways.longer + arm.drum * theta + arm.x0 + self._x0
        machine = Machine(arm, self._laws, self._values)
        at = CableMotion(x, x_d, ways.length, arm, arm.drum * theta_d, theta / arm.gear, theta, self._since_began)
        pull = machine.pull(at, self._memory)
        inertia = self._arm.motor_inertia / self._arm.drum
        more = arm.motor_inertia / arm.drum - inertia
        net = self._drive - inertia * self._theta_dd - more * self._felt_theta_dd
        torque = np.einsum("tij,tj->ti", ways.Z, net) - load
        rubbing = machine.resistance(JointMotion(alpha, alpha_d, self._since_began))
        if machine.loses_on_the_way:
            lost = ways.Z * machine.ratios_lost(ways.Z, alpha_d, ways.wraps)
            rubbing = rubbing + np.einsum("tij,tj->ti", lost, np.maximum(net, 0.0))
        if rubbing.ndim:  # it turns over between one kept row and the next
            torque = torque - self._low_pass.slower(rubbing.T, self._step, CUTOFF_HZ).T
        return np.concatenate([(net - pull).T, torque.T])


@dataclass(frozen=True)
class _Ways:
    """The cables' ways at every row."""

    Z: Array
    length: Array
    longer: Array
    """than in the straight pose"""
    wraps: Array

    @classmethod
    def of(cls, arm: Arm, alpha: Array) -> "_Ways":
        cables = geometry_of_poses(arm, alpha)
        return cls(cables.Z, cables.length, cables.length - lengths(arm, np.zeros(arm.N)), cables.wraps)


def _load(arm: Arm, alpha: Array, alpha_d: Array, alpha_dd: Array) -> Array:
    """Torque that the motion takes, without friction, (S, N), N m."""
    k = terms(arm, alpha, alpha_d)
    return np.einsum("tij,tj->ti", k.M, alpha_dd) + k.c + k.g


def _alike(a: Arm, b: Arm, names: tuple[str, ...]) -> bool:
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names)
