"""What the residuals would be were the arm another, or its angles others than read.

Taken at the filter's rows: geometry, loads and elongations are slow, only the motors' forces need the filter, and these stay.
Angles are the state's: with vision's own noise in them, changes would share it with the residuals.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import memory_states
from identification.residuals import law_forces, cable_motion
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.arm import Arm
from mechanism.cable_lengths import Z, lengths
from mechanism.dynamics import terms
from mechanism.elasticity import elongation, elongation_rate
from mechanism.laws import Stretching
from mechanism.machine import Machine

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AngleError:
    """By how much the angles are others than read, each (S, N) or (N,), rad, with derivatives."""

    by: Array
    by_d: Array | float = 0.0
    by_dd: Array | float = 0.0


_AS_READ = AngleError(np.zeros(1))


class ResidualSensitivity:
    """One recording at the vector p."""

    def __init__(self, s: Signals, u: Unknowns, p: Array, recording: int) -> None:
        at = s.low_pass.kept
        self._s, self._at = s, at
        self._values, self._x0, self._laws = u.values(p), u.get(p, "x0", recording), u.laws
        delay = float(u.get(p, "delay", recording)[0])
        z = memory_states(Machine(s.arm, u.laws, self._values), cable_motion(s, self._x0), s.step)
        self._drive = s.low_pass(law_forces(s, u.laws, self._values, self._x0, delay, z).drive.T).T
        self._z = z[at]
        self._seen = s.alpha[at], s.alpha_d[at]
        self._alpha = s.alpha[at], s.alpha_d[at], s.alpha_dd[at]
        self._jerk = np.gradient(s.alpha_dd, s.step, axis=0)[at]
        self._motion = s.theta[at], s.theta_d[at], s.theta_dd[at]
        self._base = self._residual(s.arm, _AS_READ)

    def late(self, by: Array | float) -> AngleError:
        """Frames that show what the arm did `by` (S,), s, later than their stamps say."""
        by = np.broadcast_to(by, len(self._at))[:, None]
        _, alpha_d, alpha_dd = self._alpha
        return AngleError(by * alpha_d, by * alpha_dd, by * self._jerk)

    def change(self, arm: Arm | None = None, turned: AngleError = _AS_READ) -> Array:
        """Of the residuals, (C, S)."""
        return self._residual(arm or self._s.arm, turned) - self._base

    def _residual(self, arm: Arm, turned: AngleError) -> Array:
        theta, theta_d, theta_dd = self._motion
        seen, seen_d = self._seen[0] + turned.by, self._seen[1] + turned.by_d
        alpha, alpha_d, alpha_dd = (
            a + by for a, by in zip(self._alpha, (turned.by, turned.by_d, turned.by_dd), strict=True)
        )
        x_d = elongation_rate(arm, Z(arm, seen), seen_d, theta_d)
        # x0 of the fit is beyond what the signals' arm says, and its arm may say otherwise
        x = elongation(arm, seen, theta) + self._x0
        machine = Machine(arm, self._laws, self._values)
        pull = machine.pull(Stretching(x, x_d, lengths(arm, seen), arm, arm.drum * theta_d), self._z)
        net = self._drive - arm.motor_inertia / arm.drum * theta_dd
        k = terms(arm, alpha, alpha_d)
        load = np.einsum("tij,tj->ti", k.M, alpha_dd) + k.c + k.g + machine.resistance(alpha_d)
        torque = np.einsum("tij,tj->ti", Z(arm, alpha), net) - load
        return np.concatenate([(net - pull).T, torque.T])
