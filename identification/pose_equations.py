"""The equations of arm and motors on recordings, and how frames and forces miss them, for numbers of arm and laws together."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import memory_states
from identification.dataset.series import interpolated
from identification.filters import low_pass
from identification.model_file import Model, observing_machine
from identification.pose_numbers import DRAGGED, MARKER_OFFSET, SoughtNumber
from identification.pose_rows import PoseRows
from mechanism.arm import Arm, arm_of
from mechanism.cable_lengths import geometry_of_poses, lengths
from mechanism.description import Neck
from mechanism.dynamics import terms
from mechanism.friction import HELD_VARIANCE
from mechanism.laws import CableMotion, JointMotion, MotorMotion
from mechanism.machine import Machine
from mechanism.toleranced_numbers import moved

Array = NDArray[np.float64]

_DIFFERENCE_RAD = 1e-6
"""of the arm's stiffness by differences"""
_ELONGATION_D_SHARE = 1 / 7.5
"""of the frames' rate, up to which rates of elongation are told (docs/thresholds.md)"""


@dataclass(frozen=True)
class Misfit:
    """What a recording's equations miss."""

    angles: Array
    """of the frames less predicted ones, (F, N), rad"""
    motors: Array
    """forces of the motors less modelled ones, (T, M), N"""


class PoseEquations:
    """The equations of several recordings, functions of numbers p (P,) in prior sigmas from their prior means."""

    def __init__(self, neck: Neck, model: Model, rows: Sequence[PoseRows], numbers: Sequence[SoughtNumber]) -> None:
        self.neck, self.model, self.rows, self.numbers = neck, model, rows, numbers
        self.base = observing_machine(model, arm_of(neck))
        self.sigma = np.array([n.sigma for n in numbers])
        self.mean = np.array([n.mean for n in numbers])
        self.low = (np.array([n.low for n in numbers]) - self.mean) / self.sigma
        self.high = (np.array([n.high for n in numbers]) - self.mean) / self.sigma
        self.late = [np.zeros(len(r.frames.time)) for r in rows]
        """by how much frames are later than their stamps, (F,), s, where the equations are linearised"""
        self.shifted = [(r.alpha, r.alpha_d, r.alpha_dd) for r in rows]
        """the state of the joints, on the clock as it was found"""
        self.moved = [np.zeros_like(r.alpha) for r in rows]
        """of each recording, (T, N), rad: from the state to where cables pull the arm, where the equations are linearised"""
        self._drawing = [i for i, n in enumerate(numbers) if n.drawing]
        self._markers = [i for i, n in enumerate(numbers) if n.name == MARKER_OFFSET]
        self._arms: dict[bytes, Arm] = {}
        self._loads: dict[tuple[bytes, int], tuple[Array, ...]] = {}

    def _arm(self, p: Array) -> Arm:
        """The arm with the drawing's numbers moved; the last ones are kept, as most columns share them."""
        key = p[self._drawing].tobytes()
        if key not in self._arms:
            if len(self._arms) > 2:
                self._arms.clear()
                self._loads.clear()
            drawing = [n.drawing for n in self.numbers if n.drawing]
            self._arms[key] = arm_of(moved(self.neck, drawing, (p * self.sigma)[self._drawing].tolist()))
        return self._arms[key]

    def _geometry(self, p: Array, r: int) -> tuple[Array, ...]:
        """Length, wraps, Z, M alpha'' + c + g of a recording's rows."""
        arm = self._arm(p)
        key = (p[self._drawing + self._markers].tobytes(), r)
        if key not in self._loads:
            alpha = self._angles(p, r)
            g = geometry_of_poses(arm, alpha)
            k = terms(arm, alpha, self._speed(r))
            load = np.einsum("tij,tj->ti", k.M, self.shifted[r][2]) + k.c + k.g
            self._loads[key] = (g.length - lengths(arm, np.zeros(arm.N)), g.wraps, g.Z, load, g.length)
        return self._loads[key]

    def _angles(self, p: Array, r: int) -> Array:
        """Angles between the bars where the equations are linearised, (T, N), rad."""
        markers = (self.mean + p * self.sigma)[self._markers]
        return self.shifted[r][0] + self.moved[r] - (markers if self._markers else 0.0)

    def _speed(self, r: int) -> Array:
        """Speeds of the joints where the equations are linearised, (T, N), rad/s."""
        return self.shifted[r][1]

    def _machine(self, p: Array, r: int) -> tuple[Machine, Array]:
        """The machine of a recording, and by how much its frames are later than their stamps say, (F,), s."""
        values = {name: v.copy() for name, v in self.base.values.items()}
        x0, late = np.zeros(self.neck.M), np.zeros(len(self.rows[r].frames.time))
        from_middle = self.rows[r].frames.time - np.mean(self.rows[r].frames.time)
        for n, value in zip(self.numbers, self.mean + p * self.sigma, strict=True):
            if n.recording == r and n.name == "x0" and n.index is not None:
                x0[n.index - 1] = value
            elif n.recording == r and n.name in ("clock", "skew"):
                late = late + value * (from_middle if n.name == "skew" else 1.0)
            elif n.kind == "law" and n.recording is None:
                values[n.name][0 if n.index is None else n.index - 1] = value
        return Machine(replace(self._arm(p), x0=x0), self.base.names, values), late

    def _dragged(self, p: Array, r: int) -> Array:
        """Shares of the motors' speeds that a recording's cables feel while motors cross their play, (M,)."""
        out = np.zeros(self.neck.M)
        for n, value in zip(self.numbers, self.mean + p * self.sigma, strict=True):
            if n.recording == r and n.name == DRAGGED and n.index is not None:
                out[n.index - 1] = value
        return out

    def _balance(self, machine: Machine, p: Array, r: int, *geometry: Array) -> tuple[Array, Array]:
        """As `_torque` below, of a recording with numbers p; geometry: wound, wraps, Z, load and length."""
        return _torque(machine, self._dragged(p, r), self.rows[r], self._speed(r), *geometry)

    def misfit(self, p: Array, r: int, compliance: Array) -> Misfit:
        """How frames and forces of a recording miss the equations; compliance (T, N, N): of the arm on its cables, rad/(N m)."""
        rows = self.rows[r]
        machine, late = self._machine(p, r)
        wound, wraps, Z, load, length = self._geometry(p, r)
        torque, tension = self._balance(machine, p, r, wound, wraps, Z, load, length)
        error = self.moved[r] + np.einsum("tij,tj->ti", compliance, torque)
        # frames are later than their stamps say, and so is the state that was made of them
        seen_at = rows.frames.time + late - self.late[r]
        state = interpolated(seen_at, rows.log_time, rows.state[0])
        predicted = state + interpolated(rows.frames.time + late, rows.time, error)
        return Misfit(rows.frames.alpha - predicted, _motor_misfit(machine, rows, wraps, tension))

    def motor_misfit(self, p: Array, r: int) -> Array:
        """Forces of a recording's motors less modelled ones, (T, M), N."""
        rows, (machine, _) = self.rows[r], self._machine(p, r)
        wound, wraps, Z, load, length = self._geometry(p, r)
        tension = self._balance(machine, p, r, wound, wraps, Z, load, length)[1]
        return _motor_misfit(machine, rows, wraps, tension)

    def held_variance(self, p: Array, r: int, compliance: Array) -> Array:
        """Variance of each frame's angles, (F, N), rad^2, by what dry friction holds at rest, which no law of speed tells."""
        rows = self.rows[r]
        machine, late = self._machine(p, r)
        wound, wraps, Z, load, length = self._geometry(p, r)
        speed = self._speed(r)
        tension = self._balance(machine, p, r, wound, wraps, Z, load, length)[1]
        held = machine.held_torque(JointMotion(rows.alpha, speed), Z, wraps, tension)
        variance = np.einsum("tij,tj->ti", compliance**2, HELD_VARIANCE * held**2)
        return interpolated(rows.frames.time + late, rows.time, variance)

    def compliance(self, p: Array, r: int) -> Array:
        """Compliance of the arm on its cables at the rows, (T, N, N), rad/(N m)."""
        machine, _ = self._machine(p, r)
        columns = []
        for i in range(machine.arm.N):
            torques = []
            for step in (_DIFFERENCE_RAD, -_DIFFERENCE_RAD):
                alpha = self._angles(p, r) + step * np.eye(machine.arm.N)[i]
                g = geometry_of_poses(machine.arm, alpha)
                load = terms(machine.arm, alpha, np.zeros_like(alpha)).g
                wound = g.length - lengths(machine.arm, np.zeros(machine.arm.N))
                torques.append(self._balance(machine, p, r, wound, g.wraps, g.Z, load, g.length)[0])
            columns.append((torques[0] - torques[1]) / (2 * _DIFFERENCE_RAD))
        # torque falls as the angle grows
        return -np.linalg.pinv(np.stack(columns, axis=-1))

    def move(self, p: Array, r: int) -> None:
        """Linearises a recording's equations where its cables pull the arm to."""
        rows, (machine, late) = self.rows[r], self._machine(p, r)
        at = rows.time - np.interp(rows.time, rows.frames.time, late)
        alpha, alpha_d, alpha_dd = (interpolated(at, rows.log_time, values) for values in rows.state)
        self.shifted[r], self.late[r] = (alpha, alpha_d, alpha_dd), late
        self._loads.clear()
        wound, wraps, Z, load, length = self._geometry(p, r)
        torque = self._balance(machine, p, r, wound, wraps, Z, load, length)[0]
        self.moved[r] = self.moved[r] + np.einsum("tij,tj->ti", self.compliance(p, r), torque)
        self._loads.clear()


def _motor_misfit(machine: Machine, rows: PoseRows, wraps: Array, tension: Array) -> Array:
    """Forces of the motors less modelled ones, (T, M), N, at the cables' tensions (T, M), N."""
    arm = machine.arm
    turning = MotorMotion(
        theta_d=rows.theta_d,
        tension=np.maximum(tension, 0.0),
        wrap=wraps.sum(axis=1),
        theta=rows.theta,
        drum_angle=rows.theta / arm.gear,
        force=rows.f,
        time=(rows.time - rows.time[0])[:, None],
        memory=machine.memory_about_rows(rows.theta),
    )
    acting = machine.acting_force(rows.f, rows.step)
    return acting - machine.friction(turning) - arm.motor_inertia / arm.drum * rows.theta_dd - tension


def _torque(
    machine: Machine,
    dragged: Array,
    rows: PoseRows,
    speed: Array,
    wound: Array,
    wraps: Array,
    Z: Array,
    load: Array,
    length: Array,
) -> tuple[Array, Array]:
    """What cables pull beyond what the arm needs, (T, N), N m, and their tensions (T, M), N."""
    arm = machine.arm
    since = (rows.time - rows.time[0])[:, None]
    x = wound + arm.drum * rows.theta + arm.x0
    x_d = _as_the_camera_tells(arm.drum * rows.theta_d - np.einsum("tij,ti->tj", Z, speed), rows)
    at = CableMotion(
        x=x,
        x_d=x_d,
        length=length,
        arm=arm,
        travel_d=arm.drum * rows.theta_d,
        drum_angle=rows.theta / arm.gear,
        theta=rows.theta,
        time=since,
    )
    z = memory_states(machine, at, rows.step)
    tension = np.broadcast_to(np.maximum(machine.pull(at, z) + dragged * machine.undragged(at, z), 0.0), x.shape)
    resistance = machine.resistance(JointMotion(rows.alpha, speed, since))
    return np.einsum("tij,tj->ti", machine.arriving(Z, speed, wraps), tension) - load - resistance, tension


def _as_the_camera_tells(x_d: Array, rows: PoseRows) -> Array:
    """Rates of elongation, (T, M), m/s, without what is faster than frames tell.

    Motors are counted in every row and joints seen in few: where a motor's speed jumps, the joints' speeds lack their share of
    it. What is left of the two looks like stretching, and damping that is fitted to it comes out too small, with a clock that is
    late.
    """
    frame_rate = 1 / float(np.median(np.diff(rows.frames.time)))
    return low_pass(x_d, 1 / rows.step, _ELONGATION_D_SHARE * frame_rate)
