"""Numbers of arm and laws by which motor angles tell the joints: what a camera leaves behind for when it is gone.

`identify` asks what friction and elasticity are if the drawing is right. Where joints shall be told without a camera the question
is another one: with which numbers, of laws and drawing together, does the arm stand where the camera saw it? With the motors'
angles given, cables pull the arm to where

    Z t(alpha, theta) = M alpha'' + c + g + joint friction                                    (44), (53)

so that numbers are sought which put every frame's angles there. Numbers of the drawing are known to their tolerance beforehand,
those of the laws as `identify` left them; the motors' equation (43) tells the level of the tensions. Rows of correlated residuals
count for what they are worth.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import memory_states
from identification.dataset.dataset import DataSet
from identification.dataset.frames import FrameAngles, frame_angles
from identification.dataset.series import interpolated
from identification.model_file import Model, PoseModel, PoseNumber, PoseResidual, covariance_of, machine_of
from identification.unknowns import terms_of
from mechanism.arm import Arm, arm_of
from mechanism.cable_lengths import geometry_of_poses, lengths
from mechanism.description import Neck
from mechanism.dynamics import terms
from mechanism.laws import CableMotion, JointMotion, MotorMotion, Term
from mechanism.machine import Machine
from mechanism.toleranced_numbers import TolerancedNumber, moved, toleranced_numbers
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread

Array = NDArray[np.float64]

_ROWS_HZ = 50.0
"""rate at which the equations are formed"""
_MAX_ITERATIONS, _TOLERANCE = 12, 0.01
"""of Gauss and Newton; prior sigmas of every number that the last step changes at most"""
_MAX_STEP = 10.0
"""prior sigmas by which a number moves at once"""
_WEIGHTED_ANEW = 6
"""iterations in which weights follow the residuals"""
_STEP = 1e-3
"""prior sigmas: of the differences"""
_X0_SIGMA_M = 3e-3
"""of a pre-elongation, before a recording; a motor's first row stands anywhere (docs/thresholds.md)"""
_LAW_RANGE_SHARE = 0.25
"""share of a law's range that is its number's prior sigma at most (docs/thresholds.md)"""
_LAW_SIGMAS = 3.0
"""by how much the sigmas of `identify` are widened: they hold if the drawing is right (docs/thresholds.md)"""
_MIN_LAW_SIZES = 0.5
"""sizes of a term that its prior sigma is at least (docs/thresholds.md)"""
_CLOCK_SIGMA_S, _SKEW_SIGMA = 4e-3, 3e-5
"""s, and ratio, at least, of a recording's clock, which was aligned by laws whose numbers move here (docs/thresholds.md)"""
_DIFFERENCE_RAD = 1e-6
"""of the arm's stiffness by differences"""
_LAGS = 60
"""frames up to which residuals are taken to be correlated"""
_MOTOR_HZ = 1.0
"""independent values of the motors' equation in a second (docs/thresholds.md)"""


@dataclass(frozen=True)
class _Number:
    """One number that is sought: of the drawing, a law, or a recording."""

    name: str
    index: int | None
    mean: float
    sigma: float
    low: float
    high: float
    drawing: TolerancedNumber | None = None
    recording: int | None = None


@dataclass(frozen=True)
class _Rows:
    """What is known of one recording at rows of `step` s, and its frames."""

    step: float
    time: Array
    alpha: Array
    alpha_d: Array
    alpha_dd: Array
    theta: Array
    theta_d: Array
    theta_dd: Array
    f: Array
    frames: FrameAngles
    log_time: Array
    """of all rows of the state, (R,), s"""
    state: tuple[Array, Array, Array]
    """alpha with its derivatives in them, each (R, N)"""
    clock_sigma: float


@dataclass(frozen=True)
class _Misfit:
    """Of one recording: angles of the frames less predicted ones (F, N), rad; motor forces less modelled ones (T, M), N."""

    angles: Array
    motors: Array


@one_blas_thread
def calibrate_pose(recordings: Sequence[DataSet], model: Model, neck: Neck | None = None) -> PoseModel:
    """Numbers of arm and laws by which motors tell the joints, fitted to recordings of one arm.

    neck: the description that the numbers are relative to; that of the recordings unless given. Raises Refused where no frame shows
    all joints.
    """
    neck = neck or recordings[0].neck
    rows = [_rows(data) for data in recordings]
    if not sum(np.isfinite(r.frames.alpha).all(axis=1).sum() for r in rows):
        raise Refused("identify", "no frame shows all joints", "record with every marker in view")
    try:
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            problem = _Problem(neck, model, rows, _numbers(neck, model, rows))
            p, covariance = problem.solved()
            return problem.result(p, covariance)
    except np.linalg.LinAlgError as error:
        raise Refused(
            "identify", f"motors cannot be made to tell the joints ({error})", "is a column in another unit?"
        ) from error


def with_pose(model: Model, recordings: Sequence[DataSet], neck: Neck | None = None) -> Model:
    """The model with the numbers by which motors tell the joints; as it is where these recordings do not tell them."""
    try:
        return model.model_copy(update={"pose": calibrate_pose(recordings, model, neck)})
    except Refused:
        return model


def _rows(data: DataSet) -> _Rows:
    state = data.state
    log_step = float(np.mean(np.diff(state.time)))
    part = slice(None, None, max(1, round(1 / (_ROWS_HZ * log_step))))
    f = state.matrix("f")
    f = np.concatenate([f[:1], (f[:-1] + f[1:]) / 2])  # a force holds from its row on
    frames = frame_angles(data)
    margin = 2 / _ROWS_HZ
    frames = frames.within(state.time[0] + margin, state.time[-1] - margin)
    frames = frames.clear_of(data.clock.get("log_gaps", ()), margin)
    alpha, bridged = frames.alpha, state.matrix("bridged")
    if bridged.size:  # where the state was not seen it is no place to linearise at
        alpha = np.where(interpolated(frames.time, state.time, bridged) > 0, np.nan, alpha)
    names = [("alpha", s) for s in ("", "_d", "_dd")] + [("theta", s) for s in ("", "_d", "_dd")]
    alpha0, alpha_d, alpha_dd, theta, theta_d, theta_dd = (state.matrix(*name)[part] for name in names)
    sigma = data.clock.get("offset_sigma_s")
    return _Rows(
        step=log_step * part.step,
        time=state.time[part],
        alpha=alpha0,
        alpha_d=alpha_d,
        alpha_dd=alpha_dd,
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        f=f[part],
        frames=replace(frames, alpha=alpha),
        log_time=state.time,
        state=(state.matrix("alpha"), state.matrix("alpha", "_d"), state.matrix("alpha", "_dd")),
        clock_sigma=max(_CLOCK_SIGMA_S, float(sigma) if sigma else 0.0),
    )


def is_shape(term: Term) -> bool:
    """Whether a law's term says how it acts, not how much: such as a time constant. It stays as `identify` left it."""
    return term.of == "arm" and (not term.linear or (term.low > 0 and term.name != "E"))


def _numbers(neck: Neck, model: Model, rows: Sequence[_Rows]) -> list[_Number]:
    out = [_Number(n.name, None, 0.0, n.sigma, -0.5, 0.5, drawing=n) for n in toleranced_numbers(neck) if n.sigma > 0]
    arm = arm_of(neck)
    values = machine_of(model, arm).values
    known = {(p.name, p.index): i for i, p in enumerate(model.parameters)}
    variances = np.diag(covariance_of(model))
    for term in terms_of(model.laws):
        if is_shape(term):
            continue
        span = term.high - term.low
        most = _LAW_RANGE_SHARE * span if np.isfinite(span) else np.inf
        for i in range(term.count(arm)):
            index = None if term.of == "arm" else i + 1
            value = float(values[term.name][i])
            place = known.get((term.name, index))
            sigma = np.inf if place is None else float(np.sqrt(variances[place]))
            sure = place is not None and model.parameters[place].identified
            if not sure and term.name not in ("k", "E"):
                value = min(max(value, -2 * term.size), 2 * term.size) if np.isfinite(span) else value
            sigma = min(max(_LAW_SIGMAS * sigma, _MIN_LAW_SIZES * term.size), most)
            if not np.isfinite(sigma):
                sigma = max(abs(value), term.size)
            out.append(_Number(term.name, index, value, sigma, term.low, term.high))
    given = {p.index: p.value for p in model.parameters if p.name == "x0"}
    for r, recording in enumerate(rows):
        for j in range(arm.M):
            mean = given.get(j + 1, float(arm.x0[j]))
            out.append(_Number("x0", j + 1, mean, _X0_SIGMA_M, -0.05, 0.05, recording=r))
        out.append(_Number("clock", None, 0.0, recording.clock_sigma, -0.05, 0.05, recording=r))
        out.append(_Number("skew", None, 0.0, _SKEW_SIGMA, -1e-3, 1e-3, recording=r))
    return out


class _Problem:
    """The fit: numbers in units of their prior sigmas, from their prior means."""

    def __init__(self, neck: Neck, model: Model, rows: Sequence[_Rows], numbers: Sequence[_Number]) -> None:
        self.neck, self.model, self.rows, self.numbers = neck, model, rows, numbers
        self.base = machine_of(model, arm_of(neck))
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
        self._sigmas: dict[int, tuple[Array, Array]] = {}
        self._drawing = [i for i, n in enumerate(numbers) if n.drawing]
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
        """Length, wrap, Z, M alpha'' + c + g of a recording's rows."""
        arm = self._arm(p)
        key = (p[self._drawing].tobytes(), r)
        if key not in self._loads:
            alpha = self.shifted[r][0] + self.moved[r]
            g = geometry_of_poses(arm, alpha)
            k = terms(arm, alpha, self._speed(r))
            load = np.einsum("tij,tj->ti", k.M, self.shifted[r][2]) + k.c + k.g
            self._loads[key] = (g.length - lengths(arm, np.zeros(arm.N)), g.wrap, g.Z, load, g.length)
        return self._loads[key]

    def _speed(self, r: int) -> Array:
        """Of the joints where the equations are linearised, (T, N), rad/s."""
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
            elif n.drawing is None and n.recording is None:
                values[n.name][0 if n.index is None else n.index - 1] = value
        return Machine(replace(self._arm(p), x0=x0), self.base.names, values), late

    def misfit(self, p: Array, r: int, compliance: Array) -> _Misfit:
        """Of a recording; compliance (T, N, N): of the arm on its cables, rad/(N m)."""
        rows = self.rows[r]
        machine, late = self._machine(p, r)
        wound, wrap, Z, load, length = self._geometry(p, r)
        torque, tension = _torque(machine, rows, self._speed(r), wound, Z, load, length)
        error = self.moved[r] + np.einsum("tij,tj->ti", compliance, torque)
        # frames are later than their stamps say, and so is the state that was made of them
        seen_at = rows.frames.time + late - self.late[r]
        state = interpolated(seen_at, rows.log_time, rows.state[0])
        predicted = state + interpolated(rows.frames.time + late, rows.time, error)
        arm = machine.arm
        turning = MotorMotion(
            rows.theta_d,
            np.maximum(tension, 0.0),
            wrap,
            rows.theta,
            rows.theta / arm.gear,
            rows.f,
            (rows.time - rows.time[0])[:, None],
        )
        acting = machine.acting_force(rows.f, rows.step)
        forces = acting - machine.friction(turning) - arm.motor_inertia / arm.drum * rows.theta_dd - tension
        return _Misfit(rows.frames.alpha - predicted, forces)

    def compliance(self, p: Array, r: int) -> Array:
        """Of the arm on its cables at the rows, (T, N, N), rad/(N m)."""
        rows = self.rows[r]
        machine, _ = self._machine(p, r)
        columns = []
        for i in range(machine.arm.N):
            torques = []
            for step in (_DIFFERENCE_RAD, -_DIFFERENCE_RAD):
                alpha = self.shifted[r][0] + self.moved[r] + step * np.eye(machine.arm.N)[i]
                g = geometry_of_poses(machine.arm, alpha)
                load = terms(machine.arm, alpha, np.zeros_like(alpha)).g
                wound = g.length - lengths(machine.arm, np.zeros(machine.arm.N))
                torques.append(_torque(machine, rows, self._speed(r), wound, g.Z, load, g.length)[0])
            columns.append((torques[0] - torques[1]) / (2 * _DIFFERENCE_RAD))
        # torque falls as the angle grows
        return -np.linalg.pinv(np.stack(columns, axis=-1))

    def solved(self) -> tuple[Array, Array]:
        """Numbers in prior sigmas, with their covariance."""
        p: Array = np.zeros(len(self.numbers))
        covariance: Array = np.eye(len(p))
        for iteration in range(_MAX_ITERATIONS):
            for r in range(len(self.rows)):
                self._move(p, r)
                if iteration < _WEIGHTED_ANEW:
                    self._sigmas[r] = self._sigma(p, r)
            normal, gradient = np.eye(len(p)), -p
            for r in range(len(self.rows)):
                own_normal, own_gradient = self._normal_equations(p, r)
                normal, gradient = normal + own_normal, gradient + own_gradient
            if not (np.isfinite(normal).all() and np.isfinite(gradient).all()):
                raise Refused(
                    "identify", "no numbers put the arm where the camera saw it", "is it this arm's neck.yaml?"
                )
            step = np.linalg.solve(normal, gradient)
            step *= min(1.0, _MAX_STEP / max(float(np.max(np.abs(step))), 1e-300))
            best = np.clip(p + step, self.low, self.high)
            change = float(np.max(np.abs(best - p)))
            p, covariance = best, np.linalg.inv(normal)
            if change < _TOLERANCE:
                break
        return p, covariance

    def _move(self, p: Array, r: int) -> None:
        """Linearises a recording's equations where its cables pull the arm to."""
        rows, (machine, late) = self.rows[r], self._machine(p, r)
        at = rows.time - np.interp(rows.time, rows.frames.time, late)
        alpha, alpha_d, alpha_dd = (interpolated(at, rows.log_time, values) for values in rows.state)
        self.shifted[r], self.late[r] = (alpha, alpha_d, alpha_dd), late
        self._loads.clear()
        wound, _, Z, load, length = self._geometry(p, r)
        torque = _torque(machine, rows, self._speed(r), wound, Z, load, length)[0]
        self.moved[r] = self.moved[r] + np.einsum("tij,tj->ti", self.compliance(p, r), torque)
        self._loads.clear()

    def _sigma(self, p: Array, r: int) -> tuple[Array, Array]:
        """Of the frames' angles (F, N), rad, and of the motors' equation in each row, (M,), N."""
        misfit = self.misfit(p, r, self.compliance(p, r))
        return self._angle_sigma(misfit, r), self._motor_sigma(misfit, r)

    def _normal_equations(self, p: Array, r: int) -> tuple[Array, Array]:
        compliance = self.compliance(p, r)
        base = self.misfit(p, r, compliance)
        seen = np.isfinite(base.angles)
        weight, motor_weight = (1 / sigma for sigma in self._sigmas[r])
        angle_columns, motor_columns = [], []
        for i, n in enumerate(self.numbers):
            if n.recording not in (None, r):
                angle_columns.append(np.zeros(int(seen.sum())))
                motor_columns.append(np.zeros(base.motors.size))
                continue
            q = p.copy()
            q[i] += _STEP
            other = self.misfit(q, r, compliance)
            angle_columns.append((((base.angles - other.angles) / _STEP) * weight)[seen])
            motor_columns.append((((base.motors - other.motors) / _STEP) * motor_weight).ravel())
        H, G = np.stack(angle_columns, axis=1), np.stack(motor_columns, axis=1)
        normal = H.T @ H + G.T @ G
        gradient = H.T @ (base.angles * weight)[seen] + G.T @ (base.motors * motor_weight).ravel()
        return normal, gradient

    def _angle_sigma(self, misfit: _Misfit, r: int) -> Array:
        """Of each frame's angles, (F, N), rad, wider by how much residuals exceed the frames' noise and are correlated."""
        sigma = self.rows[r].frames.sigma
        ratio = np.nanvar(misfit.angles / sigma, axis=0)
        widened = np.sqrt(np.maximum(ratio, 1.0) * np.array([_correlation_time(a) for a in (misfit.angles / sigma).T]))
        return sigma * widened

    def _motor_sigma(self, misfit: _Misfit, r: int) -> Array:
        """Of the motors' equation, (M,), N, in each row."""
        rows_each = max(1.0, 1 / (_MOTOR_HZ * self.rows[r].step))
        return np.maximum(np.sqrt(np.mean(misfit.motors**2, axis=0)), 0.1) * np.sqrt(rows_each)

    def result(self, p: Array, covariance: Array) -> PoseModel:
        """As the model's file has it: numbers of arm and laws; x0 where there is one recording."""
        kept = [
            i for i, n in enumerate(self.numbers) if n.recording is None or (len(self.rows) == 1 and n.name == "x0")
        ]
        value = self.mean + p * self.sigma
        whole = covariance * np.outer(self.sigma, self.sigma)
        misfits = [self.misfit(p, r, self.compliance(p, r)) for r in range(len(self.rows))]
        left = [self._left(m, r) for r, m in enumerate(misfits)]
        motor = np.sqrt(np.mean(np.concatenate([m.motors for m in misfits]) ** 2, axis=0))
        return PoseModel(
            numbers=tuple(
                PoseNumber(
                    name=n.name,
                    index=n.index,
                    kind="drawing" if n.drawing else ("x0" if n.name == "x0" else "law"),
                    value=float(value[i]),
                    sigma=float(np.sqrt(whole[i, i])),
                )
                for i, n in enumerate(self.numbers)
                if i in set(kept)
            ),
            covariance=tuple(tuple(float(v) for v in row) for row in whole[np.ix_(kept, kept)]),
            residual=PoseResidual(
                angle_rad=tuple(float(v) for v in np.sqrt(np.mean(np.square(left), axis=0))),
                motor_N=tuple(float(v) for v in motor),
                low_alpha=tuple(float(v) for v in np.min([r.alpha.min(axis=0) for r in self.rows], axis=0)),
                high_alpha=tuple(float(v) for v in np.max([r.alpha.max(axis=0) for r in self.rows], axis=0)),
            ),
        )

    def _left(self, misfit: _Misfit, r: int) -> Array:
        """What is left of the angles beyond the frames' own noise, (N,), rad: by successive frames, whose noise differs."""
        out = []
        for angles, sigma in zip(misfit.angles.T, self.rows[r].frames.sigma.T, strict=True):
            both = np.isfinite(angles[1:]) & np.isfinite(angles[:-1])
            shared = float(np.mean((angles[1:] * angles[:-1])[both])) if both.any() else float(np.mean(sigma**2))
            out.append(np.sqrt(max(shared, 0.0)))
        return np.array(out)


def _torque(
    machine: Machine, rows: _Rows, speed: Array, wound: Array, Z: Array, load: Array, length: Array
) -> tuple[Array, Array]:
    """What cables pull beyond what the arm needs, (T, N), N m, and their tensions (T, M), N."""
    arm = machine.arm
    since = (rows.time - rows.time[0])[:, None]
    x = wound + arm.drum * rows.theta + arm.x0
    x_d = arm.drum * rows.theta_d - np.einsum("tij,ti->tj", Z, speed)
    at = CableMotion(x, x_d, length, arm, arm.drum * rows.theta_d, rows.theta / arm.gear, rows.theta, since)
    tension = np.broadcast_to(machine.tension(at, memory_states(machine, at, rows.step)), x.shape)
    resistance = machine.resistance(JointMotion(rows.alpha, speed, since))
    return np.einsum("tij,tj->ti", Z, tension) - load - resistance, tension


def _correlation_time(residual: Array) -> float:
    """Rows of a residual (F,) that count as one, NaN where unknown: the sum of its correlations up to the first below zero."""
    r = np.where(np.isfinite(residual), residual - np.nanmean(residual), 0.0)
    power = float(r @ r)
    if power == 0:
        return 1.0
    total = 1.0
    for lag in range(1, min(_LAGS, len(r) - 1)):
        correlation = float(r[lag:] @ r[:-lag]) / power
        if correlation <= 0:
            break
        total += 2 * correlation
    return total
