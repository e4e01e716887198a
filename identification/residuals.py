"""The two equations that a recording must obey, and how far it does not, with their derivatives by what is unknown.

    motor   F - Ia (R/rd) theta'' - friction - tension           (M channels, N), F the force that acts where f is written
    arm     Z (F - Ia (R/rd) theta'' - friction) - (M alpha'' + c + g) - joint friction    (N channels, N m)

Everything is formed at the log's rate and only then filtered and decimated, both sides and every column alike: the sign of
theta' of filtered signals is not the filtered sign of theta'.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import memory_states
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.laws import LAWS, Stretching, Term, Turning
from mechanism.machine import Machine

Array = NDArray[np.float64]

_DIFFERENCE = 1e-3
"""of a term's size, for its columns: laws are smooth on it, most are linear"""


@dataclass(frozen=True)
class LawForces:
    """What laws say at every row: what motors have left of the command and pull of the cables (T, M), N; resistance (T, N), N m."""

    drive: Array
    pull: Array
    resist: Array


@dataclass(frozen=True)
class ResidualRows:
    """Residuals (C, S) of the motor channels, then of the arm's, and their derivatives (C, S, P)."""

    residual: Array
    jacobian: Array


def law_forces(
    s: Signals,
    names: tuple[str, ...],
    values: Mapping[str, Array],
    x0: Array,
    delay: float,
    z: Array | None = None,
    tension: Array | None = None,
) -> LawForces:
    """The laws' forces on a recorded motion; z (T, M, states) and the tension (T, M), N, under which motors rub, where known."""
    machine = Machine(s.arm, names, values)
    at = cable_motion(s, x0)
    memory = memory_states(machine, at, s.step) if z is None else z
    pull = np.broadcast_to(machine.pull(at, memory), s.x.shape)
    turning = Turning(s.theta_d, np.maximum(pull if tension is None else tension, 0.0), s.wrap)
    drive = machine.command(delayed_forces(s, delay), s.step) - machine.friction(turning)
    return LawForces(drive, pull, np.broadcast_to(machine.resistance(s.alpha_d), s.alpha_d.shape))


def cable_motion(s: Signals, x0: Array) -> Stretching:
    """The cables of a recording."""
    return Stretching(s.x + x0, s.x_d, s.length, s.arm, s.arm.drum * s.theta_d)


def delayed_forces(s: Signals, delay: float) -> Array:
    """The forces as they act, (T, M), N."""
    if delay == 0:
        return s.f
    return np.stack([np.interp(s.time - delay, s.time, column) for column in s.f.T], axis=-1)


def residuals_of(s: Signals, base: LawForces) -> Array:
    """Residuals of one recording by the laws' forces, (C, S)."""
    net = (base.drive - s.inertial).T
    torque = np.einsum("ijt,jt->it", s.levers, net) - (s.load + base.resist).T
    return np.concatenate([s.low_pass(net - base.pull.T), s.low_pass(torque)])


def law_forces_at(s: Signals, u: Unknowns, p: Array, recording: int, tension: Array | None = None) -> LawForces:
    """The laws' forces on one recording at the vector p; tension as in `forces`."""
    delay = float(u.get(p, "delay", recording)[0])
    return law_forces(s, u.laws, u.values(p), u.get(p, "x0", recording), delay, tension=tension)


def residual_rows(s: Signals, u: Unknowns, p: Array, recording: int) -> ResidualRows:
    """Residuals and columns of one recording at the vector p."""
    n, m = s.arm.N, s.arm.M
    values, x0 = u.values(p), u.get(p, "x0", recording)
    delay = float(u.get(p, "delay", recording)[0])
    z = memory_states(Machine(s.arm, u.laws, values), cable_motion(s, x0), s.step)
    base = law_forces(s, u.laws, values, x0, delay, z)
    acting = replace(s, f=delayed_forces(s, delay))
    lasting = {term.name for name in u.laws if LAWS[name].states for term in LAWS[name].terms}
    residual = residuals_of(s, base)
    J = np.zeros((m + n, residual.shape[1], len(u.entries)))
    for (name, of), slot in u.slots.items():
        if of not in (None, recording):
            continue
        term = u.entries[slot.start].term
        h = _DIFFERENCE * term.size
        if name == "delay":
            moved = law_forces(s, u.laws, values, x0, delay + h, z)
        elif name == "x0":
            moved = law_forces(acting, u.laws, values, x0 + h, 0.0, z)
        else:
            known = None if name in lasting else z
            moved = law_forces(acting, u.laws, values | {name: values[name] + h}, x0, 0.0, known)
        J[:, :, slot] = residual_change(s, base, moved, term) / h
    return ResidualRows(residual, J)


def residual_change(s: Signals, base: LawForces, moved: LawForces, term: Term) -> Array:
    """What forces that differ in a term do to the residuals, (C, S, its places), where all its places moved at once."""
    n, m, count = s.arm.N, s.arm.M, len(s.low_pass.kept)
    drive, pull, resist = ((getattr(moved, name) - getattr(base, name)).T for name in ("drive", "pull", "resist"))
    if term.of == "joint":
        out = np.zeros((m + n, count, n))
        out[m + np.arange(n), :, np.arange(n)] = -s.low_pass(resist)
        return out
    motor = s.low_pass(drive - pull)
    if term.of == "cable":
        out = np.zeros((m + n, count, m))
        out[np.arange(m), :, np.arange(m)] = motor
        if drive.any():
            out[m:] = np.moveaxis(s.low_pass(s.levers * drive), 1, 2)
        return out
    out = np.zeros((m + n, count, 1))
    out[:m, :, 0] = motor
    if drive.any() or resist.any():
        out[m:, :, 0] = s.low_pass(np.einsum("ijt,jt->it", s.levers, drive) - resist)
    return out
