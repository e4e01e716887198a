"""The equations of motors and arm, their residuals on a recording, and the residuals' derivatives by the unknowns.

    motor   F - Ia (R/rd) theta'' - friction - tension           (M channels, N), F the force that acts where the log says f
    arm     Z (F - Ia (R/rd) theta'' - friction) - (M alpha'' + c + g) - joint friction    (N channels, N m)

Everything is formed at the log's rate and only then filtered and decimated, residuals and derivatives by the same filter: the
sign of filtered theta' is not the filtered sign of theta'.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import moved_memory, pull_memory
from identification.dataset.series import interpolated
from identification.signals import Signals
from identification.unknowns import Unknowns, memory_starts
from mechanism.laws import CableMotion, JointMotion, Law, MotorMotion, Term, law_named
from mechanism.machine import Machine

Array = NDArray[np.float64]

UNIT_FORCE = Term("unit", "N", low=-np.inf, high=np.inf, size=1.0)
"""of each motor or cable by itself: the term of `changes_by_forces` where patterns of forces belong to no law"""

_STEP = 1e-3
"""step of the differences in sizes of a term: laws are smooth on it, most are linear"""
_KEPT_PATH_MEMORIES = 2
"""of one recording's speeds, with other numbers each"""
_METHODS = ("friction", "pull", "memory_rate", "acting_force", "resistance", "loss")
"""by which a law takes part"""


@dataclass(frozen=True)
class LawForces:
    """Forces by the laws at every row: command, friction and tension, each (T, M), N; joint friction (T, N), N m."""

    acting: Array
    friction: Array
    pull: Array
    resistance: Array
    lost: Array = field(default_factory=lambda: np.zeros(()))
    """torque that cables lose on the way to each mechanism, (T, N, M), N m; one zero where they lose nothing"""

    @property
    def drive(self) -> Array:
        """Command less friction, (T, M), N."""
        return self.acting - self.friction


@dataclass(frozen=True)
class ResidualRows:
    """Residuals (C, S), of the motor channels first, then of the arm's, and their derivatives by the unknowns (C, S, P)."""

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
    """The laws' forces on a recorded motion.

    z: memory variables (T, M, states), and tension (T, M), N, on which friction depends; computed from the laws unless given.
    """
    machine = Machine(s.arm, names, values)
    pull = _pull(s, machine, x0, z)
    return LawForces(
        acting=machine.acting_force(delayed_forces(s, delay), s.step),
        friction=mean_friction(s, machine, pull if tension is None else tension),
        pull=pull,
        resistance=np.broadcast_to(machine.resistance(joint_motion(s)), s.alpha_d.shape),
        lost=torque_lost(s, machine, pull if tension is None else tension),
    )


def forces_of_moved_law(
    s: Signals,
    base: LawForces,
    names: tuple[str, ...],
    values: Mapping[str, Array],
    law: str,
    moved: Mapping[str, Array],
    x0: Array,
    delay: float,
    z: Array | None = None,
    tension: Array | None = None,
) -> LawForces:
    """`law_forces` with one law's numbers moved; base: those with `values`, which share all that the law has no part in.

    z: memory variables with `values`; computed from the laws unless given. A law that was not there comes last among the names."""
    after = {**values, **moved}
    overridden = {name for name in _METHODS if _overrides(law_named(law), name)}
    machine = Machine(s.arm, names, after)
    if "friction" in overridden and overridden <= {"friction", "memory_rate", "loss"}:
        under = base.pull if tension is None else tension
        lost = torque_lost(s, machine, under) if "loss" in overridden else base.lost
        return replace(base, friction=mean_friction(s, machine, under), lost=lost)
    if overridden == {"resistance"}:
        return replace(base, resistance=np.broadcast_to(machine.resistance(joint_motion(s)), s.alpha_d.shape))
    if overridden == {"acting_force"}:
        return replace(base, acting=machine.acting_force(delayed_forces(s, delay), s.step))
    if overridden <= {"pull", "memory_rate"}:
        return _with_other_pull(
            s, base, machine, _pull(s, machine, x0, memory_of_moved_law(s, machine, x0, law, z)), tension
        )
    return law_forces(s, names, after, x0, delay, memory_of_moved_law(s, machine, x0, law, z), tension)


def memory_of_moved_law(s: Signals, machine: Machine, x0: Array, law: str, z: Array | None) -> Array | None:
    """Memory variables of a machine in which one law's numbers have moved, from those before, z; None where these are not known."""
    return None if z is None else moved_memory(machine, remembered_motion(s, x0), s.step, law, z)


def forces_of_other_cables(
    s: Signals,
    base: LawForces,
    names: tuple[str, ...],
    values: Mapping[str, Array],
    x0: Array,
    tension: Array,
    z: Array,
) -> LawForces:
    """`law_forces` where only the cables' and the joints' motion is another one than that of `base`; tension, z: the same as there.

    Friction is that of `base`: how far cables are wound around pulleys may differ by the noise of angles only.
    """
    machine = Machine(s.arm, names, values)
    resistance = np.broadcast_to(machine.resistance(joint_motion(s)), s.alpha_d.shape)
    return replace(
        base, pull=pull_with_memory(s, machine, x0, z), resistance=resistance, lost=torque_lost(s, machine, tension)
    )


def with_other_elongations(s: Signals, base: LawForces, machine: Machine, x0: Array) -> LawForces:
    """`law_forces` where only the cables' elongations are others than those of `base`, and motors rub under the pull."""
    return _with_other_pull(s, base, machine, _pull(s, machine, x0))


def under_tension(s: Signals, base: LawForces, machine: Machine, tension: Array) -> LawForces:
    """`law_forces` where motors rub under a tension (T, M), N, instead of that of `base`."""
    if not machine.rubs_under_tension:
        return base
    return replace(base, friction=mean_friction(s, machine, tension), lost=torque_lost(s, machine, tension))


def _with_other_pull(
    s: Signals, base: LawForces, machine: Machine, pull: Array, tension: Array | None = None
) -> LawForces:
    """Forces where cables pull otherwise; tension: (T, M), N, under which motors rub all the same."""
    rubbing = base if tension is not None else under_tension(s, base, machine, pull)
    return replace(rubbing, pull=pull)


def _pull(s: Signals, machine: Machine, x0: Array, z: Array | None = None) -> Array:
    z = pull_memory(machine, remembered_motion(s, x0), s.step) if z is None else z
    return pull_with_memory(s, machine, x0, z)


def pull_with_memory(s: Signals, machine: Machine, x0: Array, z: Array) -> Array:
    """Tension of the cables, (T, M), N, with memory variables z (T, M, states)."""
    return np.broadcast_to(machine.pull(cable_motion(s, x0), z), s.x.shape)


def _overrides(law: Law, method: str) -> bool:
    return getattr(type(law), method) is not getattr(Law, method)


def mean_friction(s: Signals, machine: Machine, tension: Array) -> Array:
    """Friction of the motors in the mean over each row, (T, M), N; tension: (T, M), N, under which they rub."""
    turning = motor_motion(s, machine, tension)
    return np.broadcast_to(machine.friction(turning), s.speeds.mean.shape).mean(axis=0)


def torque_lost(s: Signals, machine: Machine, tension: Array) -> Array:
    """Torque that cables lose on the way to each mechanism under tensions (T, M), N, as `LawForces` has it."""
    if not machine.loses_on_the_way:
        return np.zeros(())
    return s.Z * machine.ratios_lost(s.Z, s.alpha_d, s.wraps) * np.maximum(tension, 0.0)[:, None]


def friction_by_tension(s: Signals, machine: Machine, tension: Array) -> Array:
    """Change of friction by a newton more than a tension (T, M), N, under which motors rub: (T, M)."""
    if not machine.rubs_under_tension:
        return np.zeros_like(tension)
    return mean_friction(s, machine, np.maximum(tension, 0.0) + 1.0) - mean_friction(s, machine, tension)


def motor_motion(s: Signals, machine: Machine, tension: Array) -> MotorMotion:
    """The motion of a recording's motors, at several speeds within each row; tension: (T, M), N, under which they rub."""
    memory = _path_memory(s, machine) if machine.remembers_path else np.zeros(())
    return MotorMotion(
        s.speeds.mean,
        np.maximum(tension, 0.0),
        s.wrap,
        s.theta,
        s.theta / s.arm.gear,
        s.f,
        s.since_began[:, None],
        s.arm,
        memory,
        s.speeds.kept_shares,
    )


def _path_memory(s: Signals, machine: Machine) -> Array:
    """Memory of the motors' path in the mean over each half row, (2, T, M, states).

    It is kept with the speeds: of the many numbers by which friction is asked for, few change it."""
    kept, numbers = s.speeds.path_memories, machine.path_numbers
    if numbers not in kept:
        if len(kept) == _KEPT_PATH_MEMORIES:
            kept.clear()
        memory = machine.memory_on_path(s.speeds.path(s.step))
        kept[numbers] = memory.reshape(len(s.time), 2, s.arm.M, machine.states).swapaxes(0, 1)
    return kept[numbers]


def joint_motion(s: Signals) -> JointMotion:
    """The motion of a recording's joints."""
    return JointMotion(s.alpha, s.alpha_d, s.since_began[:, None])


def cable_motion(s: Signals, x0: Array) -> CableMotion:
    """The motion of a recording's cables; x0: pre-elongation beyond the description's, (M,), m."""
    drum_angle, since_began = s.theta / s.arm.gear, s.since_began[:, None]
    return CableMotion(s.x + x0, s.x_d, s.length, s.arm, s.arm.drum * s.theta_d, drum_angle, s.theta, since_began)


def remembered_motion(s: Signals, x0: Array) -> CableMotion:
    """The motion of a recording's cables as these remember it; x0: as `cable_motion` has it."""
    if s.remembered is None:
        return cable_motion(s, x0)
    x, x_d = s.remembered
    return cable_motion(replace(s, x=x, x_d=x_d), x0)


def delayed_forces(s: Signals, delay: float) -> Array:
    """Logged forces shifted by `delay` s, as they act, (T, M), N."""
    if delay == 0:
        return s.f
    return interpolated(s.time - delay, s.time, s.f)


def residuals_of(s: Signals, forces: LawForces) -> Array:
    """Residuals of one recording with the laws' forces, (C, S)."""
    net = (forces.drive - s.inertial).T
    torque = np.einsum("ijt,jt->it", s.levers, net) - (s.load + forces.resistance).T
    if forces.lost.any():
        torque = torque - forces.lost.sum(axis=-1).T
    return np.concatenate([s.low_pass(net - forces.pull.T), s.low_pass(torque)])


def law_forces_at(s: Signals, u: Unknowns, p: Array, recording: int, tension: Array | None = None) -> LawForces:
    """The laws' forces on one recording at the vector p; tension as in `law_forces`."""
    delay = float(u.get(p, "delay", recording)[0])
    return law_forces(s, u.laws, u.values(p, recording), u.get(p, "x0", recording), delay, tension=tension)


def residual_rows(
    s: Signals, u: Unknowns, p: Array, recording: int, tension: Array | None = None, base: LawForces | None = None
) -> ResidualRows:
    """Residuals of one recording at the vector p, and their derivatives; tension as in `law_forces`, the same wherever p is.

    base: what `law_forces_at` gives there, where it is known."""
    n, m = s.arm.N, s.arm.M
    values, x0 = u.values(p, recording), u.get(p, "x0", recording)
    delay = float(u.get(p, "delay", recording)[0])
    machine = Machine(s.arm, u.laws, values)
    z = pull_memory(machine, remembered_motion(s, x0), s.step)
    base = base or law_forces(s, u.laws, values, x0, delay, z, tension)
    acting = replace(s, f=delayed_forces(s, delay))
    laws = {term.name: name for name in u.laws for term in law_named(name).terms}
    starts = {term.name for term in memory_starts(u.laws)}
    residual = residuals_of(s, base)
    J = np.zeros((m + n, residual.shape[1], len(u.entries)))
    for (name, of), slot in u.slots.items():
        if of not in (None, recording):
            continue
        term = u.entries[slot.start].term
        h = _STEP * term.size
        if name == "delay":
            moved = replace(base, acting=machine.acting_force(delayed_forces(s, delay + h), s.step))
        elif name == "x0":
            moved = _with_other_pull(s, base, machine, _pull(s, machine, x0 + h, z), tension)
        elif name in starts:
            moved = law_forces(s, u.laws, values | {name: values[name] + h}, x0, delay, tension=tension)
        else:
            law, change = laws[name], {name: values[name] + h}
            moved = forces_of_moved_law(acting, base, u.laws, values, law, change, x0, 0.0, z, tension)
        J[:, :, slot] = residual_change(s, base, moved, term) / h
    return ResidualRows(residual, J)


def changes_by_forces(
    s: Signals, term: Term, friction: Array | None = None, pull: Array | None = None, resistance: Array | None = None
) -> Array:
    """Changes of the residuals by K patterns of forces beyond those of the laws, (C, S, K, count), as `residual_change` has each.

    Forces as fields of `LawForces`, (K, T, M), N, or (K, T, N), N m."""
    n, m = s.arm.N, s.arm.M
    shape = next(np.shape(force) for force in (friction, pull, resistance) if force is not None)
    places = {"cable": m, "joint": n, "arm": 1}[term.of]
    out = np.zeros((m + n, len(s.low_pass.kept), shape[0], places))
    motors, joints = np.arange(m), np.arange(n)
    for k in range(shape[0]):
        if friction is not None:  # against the motors, and by their levers against the joints
            drive = -friction[k].T
            lost = s.low_pass(np.concatenate([drive[None], s.levers * drive]))
            if term.of == "cable":
                out[motors, :, k, motors], out[m:, :, k] = lost[0], np.moveaxis(lost[1:], 1, 2)
            else:
                out[:m, :, k, 0], out[m:, :, k, 0] = lost[0], lost[1:].sum(axis=1)
        if pull is not None:
            pulled = s.low_pass(pull[k].T)
            if term.of == "cable":
                out[motors, :, k, motors] -= pulled
            else:
                out[:m, :, k, 0] -= pulled
        if resistance is not None:
            held = s.low_pass(resistance[k].T)
            if term.of == "joint":
                out[m + joints, :, k, joints] -= held
            else:
                out[m:, :, k, 0] -= held
    return out


def residual_change(s: Signals, base: LawForces, moved: LawForces, term: Term) -> Array:
    """Change of the residuals by that of a term, one column for each cable, joint or arm that has it, (C, S, count).

    base, moved: forces before and after the term was changed everywhere at once.
    """
    n, m, count = s.arm.N, s.arm.M, len(s.low_pass.kept)
    drive, pull, resistance = (
        (getattr(moved, name) - getattr(base, name)).T for name in ("drive", "pull", "resistance")
    )
    if term.of == "joint":
        out = np.zeros((m + n, count, n))
        out[m + np.arange(n), :, np.arange(n)] = -s.low_pass(resistance)
        return out
    motor = s.low_pass(drive - pull)
    lost = moved.lost - base.lost
    if term.of == "cable":
        out = np.zeros((m + n, count, m))
        out[np.arange(m), :, np.arange(m)] = motor
        if drive.any():
            out[m:] = np.moveaxis(s.low_pass(s.levers * drive), 1, 2)
        if lost.any():
            out[m:] -= np.moveaxis(s.low_pass(np.moveaxis(lost, 0, -1)), 1, 2)
        return out
    out = np.zeros((m + n, count, 1))
    out[:m, :, 0] = motor
    if drive.any() or resistance.any():
        out[m:, :, 0] = s.low_pass(np.einsum("ijt,jt->it", s.levers, drive) - resistance)
    if lost.any():
        out[m:, :, 0] -= s.low_pass(lost.sum(axis=-1).T)
    return out
