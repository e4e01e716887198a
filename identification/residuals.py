"""The two equations that a recording must obey, and how far it does not, with their derivatives by what is unknown.

    motor   f(t - delay) - Ia (R/rd) theta'' - friction - tension           (M channels, N)
    arm     Z (f(t - delay) - Ia (R/rd) theta'' - friction) - (M alpha'' + c + g) - joint friction    (N channels, N m)

Everything is formed at the log's rate and only then filtered and decimated, both sides and every column alike: the sign of
theta' of filtered signals is not the filtered sign of theta'.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.memory import remembered
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.laws import LAWS, Stretching, Turning
from mechanism.machine import Machine

Array = NDArray[np.float64]

_DIFFERENCE = 1e-3
"""of a term's size, for its columns: laws are smooth on it, most are linear"""


@dataclass(frozen=True)
class Forces:
    """What laws say at every row: friction and pull of the cables (T, M), N; joints' resistance (T, N), N m."""

    rub: Array
    pull: Array
    resist: Array


@dataclass(frozen=True)
class Rows:
    """Residuals (C, S) of the motor channels, then of the arm's, and their derivatives (C, S, P)."""

    residual: Array
    jacobian: Array


def forces(s: Signals, names: tuple[str, ...], values: dict[str, Array], x0: Array, z: Array | None = None) -> Forces:
    """The laws' forces on a recorded motion; z (T, M, states) where already known."""
    machine = Machine(s.arm, names, values)
    at = Stretching(s.x + x0, s.x_d, s.length, s.arm)
    memory = remembered(machine, at, s.step) if z is None else z
    pull = np.broadcast_to(machine.pull(at, memory), s.x.shape)
    turning = Turning(s.theta_d, np.maximum(pull, 0.0), s.wrap)
    rub = np.broadcast_to(machine.friction(turning), s.x.shape)
    return Forces(rub, pull, np.broadcast_to(machine.resistance(s.alpha_d), s.alpha_d.shape))


def delayed(s: Signals, delay: float) -> Array:
    """The forces as they act, (T, M), N."""
    return np.stack([np.interp(s.time - delay, s.time, column) for column in s.f.T], axis=-1)


def rows(s: Signals, u: Unknowns, p: Array, recording: int) -> Rows:
    """Residuals and columns of one recording at the vector p."""
    n, m = s.arm.N, s.arm.M
    values, x0 = u.values(p), u.get(p, "x0", recording)
    delay = float(u.get(p, "delay", recording)[0])
    machine = Machine(s.arm, u.laws, values)
    z = remembered(machine, Stretching(s.x + x0, s.x_d, s.length, s.arm), s.step)
    base = forces(s, u.laws, values, x0, z)
    lasting = {term.name for name in u.laws if LAWS[name].states for term in LAWS[name].terms}
    motor, arm = _filtered(s, delayed(s, delay) - s.inertial - base.rub)
    own = s.low_pass(np.ascontiguousarray((s.load + base.resist).T))
    residual = np.concatenate([motor - s.low_pass(np.ascontiguousarray(base.pull.T)), arm.sum(axis=1) - own])
    J = np.zeros((m + n, residual.shape[1], len(u.entries)))
    for (name, of), slot in u.slots.items():
        if of not in (None, recording):
            continue
        term = u.entries[slot.start].term
        h = _DIFFERENCE * term.size
        if name == "delay":
            later, on_arm = _filtered(s, (delayed(s, delay + h) - delayed(s, delay)) / h)
            J[:m, :, slot.start], J[m:, :, slot.start] = later, on_arm.sum(axis=1)
            continue
        moved = (
            forces(s, u.laws, values, x0 + h, z)
            if name == "x0"
            else forces(s, u.laws, values | {name: values[name] + h}, x0, None if name in lasting else z)
        )
        _fill(J, s, slot, term.of == "arm", base, moved, h)
    return Rows(residual, J)


def _fill(J: Array, s: Signals, slot: slice, shared: bool, base: Forces, moved: Forces, h: float) -> None:
    """Columns of a term from the forces at its value and at h more, for all its cables or joints in one."""
    n, m = s.arm.N, s.arm.M
    rub, pull, resist = ((getattr(moved, name) - getattr(base, name)) / h for name in ("rub", "pull", "resist"))
    if resist.any():
        on_joint = s.low_pass(np.ascontiguousarray(resist.T))
        for i in range(n):
            J[m + i, :, slot.start if shared else slot.start + i] -= on_joint[i]
        return
    on_motor = s.low_pass(np.ascontiguousarray((rub + pull).T))
    on_arm = _filtered(s, rub)[1] if rub.any() else np.zeros((n, m, 1))
    for j in range(m):
        column = slot.start if shared else slot.start + j
        J[j, :, column] -= on_motor[j]
        J[m:, :, column] -= on_arm[:, j]


def _filtered(s: Signals, force: Array) -> tuple[Array, Array]:
    """Forces along the cables (T, M): on the motors (M, S), and by each cable on the joints (N, M, S)."""
    on_joints = np.ascontiguousarray(np.moveaxis(s.Z * force[:, None, :], 0, -1))
    return s.low_pass(np.ascontiguousarray(force.T)), s.low_pass(on_joints)
