"""Joint angles from motor angles and forces, row by row: an extended Kalman filter on the equations of motion.

Each row predicts the state over the time since the row before, under the force that acted in it, and then takes the counted motor
angles for what they are worth. The state is that of StateLayout; the angle of a joint is what its equations say plus the pose's
error, and what frames told of the model (frame_correction.py). Angles are told as the camera would see them, with what its markers
are off the bars; the state holds those of the bars.
"""

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.model_file import Model
from mechanism.description import Neck
from observation.checked_row import check_later, checked_frame, checked_numbers
from observation.equations import Equations, traced_equations
from observation.evaluated_equations import EvaluatedEquations, left_range
from observation.filter_numbers import FilterNumbers, filter_numbers
from observation.frame_correction import PASSING_SHARE, TURNING_RAD_S
from observation.prediction import Prediction
from observation.recent_motion import RecentMotion, no_motion
from observation.start_at_rest import start_at_rest
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MAX_STEP_S = 4e-3
"""s: longer rows are gone through in several steps (docs/thresholds.md)"""
MAX_GAP_S = 0.1
"""s without a row, after which the observer begins anew, whatever the log's rate (docs/thresholds.md)"""
MISSING_ROWS = 1.5
"""rows from one to the next, beyond which a row is missing (docs/thresholds.md)"""
MAX_GAP_ROWS = 4.5
"""rows from one to the next of a slower log, after which it begins anew (docs/thresholds.md)"""
SPEED_SIGMAS = 2.0
"""sigmas of a counted angle, of what a motor turns from the first row to the second: both are counted, and motors accelerate
(docs/thresholds.md)"""
_LEFT_BY_ROWS = (
    "state",
    "covariance",
    "correction",
    "motion",
    "_acceleration",
    "_force",
    "_law_forces",
    "_time",
    "_theta",
    "_began",
    "_has_just_begun",
)
"""attributes of an observer that the next row depends on"""


@dataclass(frozen=True)
class Observed:
    """The joints at one row."""

    alpha: Array
    """(N,), rad"""
    alpha_d: Array
    """(N,), rad/s"""
    covariance: Array
    """of the angles, then the rates, (2 N, 2 N)"""


@dataclass(frozen=True)
class Innovation:
    """One frame against what was told of the joints without it."""

    alpha: Array
    """expected, (N,), rad"""
    alpha_d: Array
    """expected, (N,), rad/s"""
    beside: Array
    """seen less expected, (N,), rad, NaN where not seen"""
    variance: Array
    """that `beside` should have, (N,), rad^2"""


@dataclass(frozen=True)
class FilteredRow:
    """What the filter made of one row, as a smoother needs it."""

    transition: Array | None
    """from the row before to this one, (size, size); None where the observer began"""
    origin: Array
    """the state from which this row was predicted, (size,): that after the row before, and after what this one tells of it"""
    origin_covariance: Array
    predicted: Array
    """the state before the row was measured, (size,)"""
    predicted_covariance: Array
    state: Array
    """the state after it, (size,)"""
    covariance: Array
    motion: RecentMotion


class Observer:
    """Joint angles of one arm, row by row of its controller.

    neck: the arm's description. model: of `xneck identify` or `xneck diagnose`. step_s: s, from row to row, where none is missing.
    Raises Refused where the model was not identified for this, or a law cannot be written as code.

    >>> import xneck
    >>> data = xneck.read_dataset("monday.mcap")
    >>> observer = xneck.Observer(data.neck, xneck.read_model("model.yaml"))
    >>> theta, f = data.state.matrix("theta"), data.state.matrix("f")
    >>> alpha, alpha_d, covariance = observer.step(theta[0], f[0])  # each control step: rad, rad/s; (2 N, 2 N)
    >>> alpha.shape, covariance.shape
    ((3,), (6, 6))
    """

    def __init__(self, neck: Neck, model: Model, step_s: float = 2e-3) -> None:
        if not step_s > 0:
            raise Refused(
                "observe", f"rows {step_s:g} s apart are none", "give step_s, s from row to row: 0.002 of 500 a second"
            )
        self.numbers: FilterNumbers = filter_numbers(neck, model)
        self.equations: Equations = traced_equations(self.numbers.machine)
        self.step_s = step_s
        self._evaluated = EvaluatedEquations(self.equations)
        self.prediction = Prediction(self.numbers, self._evaluated)
        self.restart()

    def restart(self) -> None:
        """Forgets all rows: the next one is the first."""
        layout = self.numbers.layout
        self.state = self.numbers.start.copy()
        self.covariance = np.diag(self.numbers.start_sigma**2)
        self.correction = self.numbers.no_correction
        self.motion = no_motion(layout.M)
        self._acceleration = np.zeros(layout.size)
        self._force: Array | None = None
        self._law_forces: list[Array | None] = [None] * len(self.numbers.machine.laws)
        self._time = 0.0
        self._theta = np.zeros(layout.M)
        self._began = 0.0
        self._has_just_begun = False
        self._transition: Array | None = None
        self._origin, self._origin_covariance = self.state, self.covariance
        self._predicted, self._predicted_covariance = self.state, self.covariance

    @property
    def missing_s(self) -> float:
        """s without a row, after which rows are missing: forces went from the last told to the next one."""
        return MISSING_ROWS * self.step_s

    @property
    def gap_s(self) -> float:
        """s without a row, after which the observer begins anew: nobody knows which forces acted meanwhile."""
        return max(MAX_GAP_S, MAX_GAP_ROWS * self.step_s)

    @np.errstate(over="ignore", invalid="ignore")  # of a model that is no arm's: refused below as what leaves its range
    def step(
        self,
        theta: Array,
        f: Array,
        time: float | None = None,
        angles: Array | None = None,
        sigma: Array | float | None = None,
    ) -> tuple[Array, Array, Array]:
        """The joints at a row: angles (N,), rad, rates (N,), rad/s, covariance of both (2 N, 2 N).

        theta: motor angles (M,), rad, growing as the cable is wound in. f: forces (M,), N at the cable, that are told to the motors
        from this row on. time: s, of the row. angles: of the joints at this row by a camera, (N,), rad, NaN where not seen, with
        their sigma: also the pose where the observer begins. Raises Refused where numbers are not finite, or not so many, or time
        does not go on.
        """
        theta, f = (checked_numbers(name, row, self.numbers.layout.M) for name, row in (("theta", theta), ("f", f)))
        if not (np.isfinite(theta).all() and np.isfinite(f).all()):
            raise Refused("observe", "a motor angle or force is not finite", "leave such rows out")
        frame = None if angles is None else checked_frame(angles, sigma, self.numbers.layout.N)
        held = self._force
        at = (0.0 if held is None else self._time + self.step_s) if time is None else float(time)
        if held is not None:
            check_later(at, self._time)
        if held is None:
            self._began = at
            self._begin(theta, f, frame and frame[0])
        elif at - self._time > self.gap_s:
            self._forget_motion()
            self._begin(theta, f, frame and frame[0])
        else:
            if self._has_just_begun:
                self._measure_motor_speeds(theta, at - self._time)
            acting = self._acting_force(f)
            self._predict(at - self._time, held, acting if at - self._time > self.missing_s else held)
            self._measure(self.numbers.layout.theta, theta, self.numbers.theta_sigma)
            travel = self.numbers.machine.arm.drum * (theta - self._theta)
            self.motion = self.motion.after(self.state[self.numbers.layout.alpha_d], travel, at - self._time)
            self._force = acting
        self._time, self._theta = at, theta
        if frame is not None:
            self._measure_joints(*frame)
        if not (np.isfinite(self.state).all() and np.abs(self.state[self.numbers.layout.alpha]).max() < np.pi):
            raise left_range(at)
        out = self.observed
        return out.alpha, out.alpha_d, out.covariance

    def snapshot(self) -> dict[str, Any]:
        """All that the rows so far leave for the next, for `restore`."""
        return copy.deepcopy({name: value for name, value in vars(self).items() if name in _LEFT_BY_ROWS})

    def restore(self, snapshot: dict[str, Any]) -> None:
        """Goes back to the row at which a snapshot was taken."""
        vars(self).update(copy.deepcopy(snapshot))

    @property
    def observed(self) -> Observed:
        """The joints at the last row."""
        return self.observed_of(self.state, self.covariance, self.motion)

    @property
    def last_row(self) -> FilteredRow:
        """The last row with the prediction that led to it."""
        return FilteredRow(
            transition=self._transition,
            origin=self._origin,
            origin_covariance=self._origin_covariance,
            predicted=self._predicted,
            predicted_covariance=self._predicted_covariance,
            state=self.state,
            covariance=self.covariance,
            motion=self.motion,
        )

    def observed_of(self, s: Array, P: Array, motion: RecentMotion) -> Observed:
        """The joints of a state (size,) with its covariance (size, size)."""
        layout = self.numbers.layout
        a, v, b = layout.alpha, layout.alpha_d, layout.pose_error
        n = layout.N
        covariance = np.empty((2 * n, 2 * n))
        cross = P[a, b]
        covariance[:n, :n] = P[a, a] + P[b, b] + cross + cross.T
        covariance[:n, n:] = P[a, v] + P[b, v]
        covariance[n:, :n] = covariance[:n, n:].T
        covariance[n:, n:] = P[v, v] + self._pose_rate_covariance(s[a], s[v], np.diag(P[b, b]), motion.mean_square)
        alpha = s[a] + s[b] + self.correction.at(s[a], s[v], motion.sides) + self.numbers.marker_offset
        alpha_d = s[v] + self.correction.rate(s[v])
        return Observed(alpha, alpha_d, covariance)

    def _pose_rate_covariance(self, alpha: Array, alpha_d: Array, variance: Array, motion: float) -> Array:
        """Of the rates, (N, N), rad^2/s^2: how fast the pose's error changes at angles (N,), rad, and speeds (N,), rad/s.

        variance: of the pose's error, (N,), rad^2. motion: mean square of the speed lately, (rad/s)^2: what is left of play and
        friction changes most where a motor turns round, and joints hardly move; and as much in slow motion as in fast."""
        numbers = self.numbers
        rate = numbers.pose_error.rate(alpha, alpha_d)
        held = numbers.let_go_rate**2 * np.maximum(variance - numbers.pose_floor**2, 0.0)
        motion = max(motion, float(alpha_d @ alpha_d))
        turning = np.tanh(np.sqrt(motion) / TURNING_RAD_S) ** 2
        left = np.maximum(numbers.pose_slope**2 * motion, numbers.pose_rate**2 * turning)
        return rate @ rate.T + np.diag(left + held)

    @property
    def friction_error(self) -> Array:
        """The force that each motor's law does not say at the last row, (M,), N."""
        return self.state[self.numbers.layout.friction_error].copy()

    @property
    def acceleration(self) -> Array:
        """Of the joints over the last row, (N,), rad/s^2."""
        return self._acceleration[self.numbers.layout.alpha_d].copy()

    def _forget_motion(self) -> None:
        """After a gap of the log: forgets all but the pre-elongations, what play drags along, and when the recording began."""
        layout = self.numbers.layout
        lasting = slice(layout.x0.start, layout.dragged.stop)
        kept, kept_covariance = self.state[lasting].copy(), self.covariance[lasting, lasting].copy()
        began, correction = self._began, self.correction
        self.restart()
        self._began, self.correction = began, correction
        self.state[lasting], self.covariance[lasting, lasting] = kept, kept_covariance

    def _begin(self, theta: Array, f: Array, angles: Array | None) -> None:
        """At rest where the cables pull the arm to, from the told angles on, or from straight."""
        layout = self.numbers.layout
        self.state[layout.theta] = theta
        if angles is not None:
            self.state[layout.alpha] = np.where(np.isfinite(angles), angles - self.numbers.marker_offset, 0.0)
        self.state, self.covariance = start_at_rest(self._evaluated, self.state, self.covariance)
        self.covariance[layout.pose_error, layout.pose_error] = self.prediction.pose_covariance_at(self.state)
        self._force = self._acting_force(f)
        self._has_just_begun = True
        self._transition = None
        self._predicted, self._predicted_covariance = self.state, self.covariance

    def _acting_force(self, f: Array) -> Array:
        """The force (M,), N, that acts until the next row, by the laws of the actuators."""
        for place, law in enumerate(self.numbers.machine.laws):
            f = law.next_force(self.numbers.machine.values, f, self._law_forces[place], self.step_s)
            self._law_forces[place] = f
        return f

    def _predict(self, interval: float, force: Array, last_force: Array) -> None:
        """Over the time to the next row, s, in steps of at most MAX_STEP_S, under a force that goes to the last one, (M,), N."""
        layout = self.numbers.layout
        count = max(1, int(np.ceil(interval / MAX_STEP_S)))
        h = interval / count
        transition = np.eye(layout.size)
        self._origin, self._origin_covariance = self.state, self.covariance
        for k in range(count):
            elapsed = self._time + (k + 0.5) * h - self._began
            acting = force + (last_force - force) * ((k + 0.5) / count)
            step = self.prediction.step(self.state, self._acceleration, acting, h, elapsed)
            F = step.transition
            self.state = self.state + step.change
            self._keep_memory_within_bounds()
            self.covariance = _symmetric(F @ self.covariance @ F.T + self.prediction.noise(step))
            if layout.S:
                F = self._gather_at_bounds(step.beyond) * F
            for speeds in (layout.alpha_d, layout.theta_d):
                self._acceleration[speeds] = step.change[speeds] / h
            transition = F @ transition
        self._transition = transition
        self._predicted, self._predicted_covariance = self.state, self.covariance

    def _keep_memory_within_bounds(self) -> None:
        memory, bound = self.numbers.layout.memory, self.numbers.memory_bound
        self.state[memory] = np.clip(self.state[memory], -bound, bound)

    def _gather_at_bounds(self, beyond: Array) -> Array:
        """What is left of each entry's sigma, (size, 1), where motion leads memory variables on to their bounds.

        beyond: by how much, (M S,). The bound gathers what lags behind it, at most two sigmas: then the variable is known. Were
        it not, counted motor angles would draw it away from its bound again and again.
        """
        memory = self.numbers.layout.memory
        sigma = np.sqrt(np.maximum(np.diag(self.covariance)[memory], 1e-300))
        left = np.ones((self.numbers.layout.size, 1))
        left[memory, 0] = np.maximum(1 - beyond / (2 * sigma), 0.0)
        self.covariance = left * self.covariance * left.T
        return left

    def _measure_motor_speeds(self, theta: Array, interval: float) -> None:
        """How fast the motors turned where the observer began, by their angles (M,), rad, at the next row, interval s later."""
        layout = self.numbers.layout
        self._has_just_begun = False
        if interval > 0:
            speed = (theta - self.state[layout.theta]) / interval
            self._measure(layout.theta_d, speed, SPEED_SIGMAS * self.numbers.theta_sigma / interval)

    def _measure(self, at: slice, values: Array, sigma: Array) -> None:
        """Entries of the state are measured: values (M,) with their sigmas."""
        P = self.covariance
        S = P[at, at] + np.diag(sigma**2)
        K = np.linalg.solve(S, P[at]).T
        self.state = self.state + K @ (values - self.state[at])
        self._keep_memory_within_bounds()
        self.covariance = _symmetric(P - K @ P[at])

    def innovation(self, angles: Array, sigma: Array) -> Innovation | None:
        """Of a frame at the last row, which was not told of it, with angles (N,) and sigmas (N,), rad; none where it just began."""
        if self._has_just_begun:
            return None
        expected, layout = self.observed, self.numbers.layout
        since = self._time - self._began
        learned = self.correction.variance(
            self.state[layout.alpha], self.state[layout.alpha_d], self.motion.sides, since
        )
        variance = np.diag(expected.covariance)[: layout.N] + learned + sigma**2
        return Innovation(expected.alpha, expected.alpha_d, angles - expected.alpha, variance)

    def _learned(self, angles: Array, sigma: Array) -> Array:
        """What frames, this one too, tell of how joints stand beside the model at this pose, (N,), rad."""
        layout = self.numbers.layout
        alpha, alpha_d = self.state[layout.alpha], self.state[layout.alpha_d]
        passing = PASSING_SHARE * np.diag(self.prediction.pose_covariance_at(self.state))
        variance = np.diag(self.covariance)[layout.alpha] + passing + sigma**2
        sides, since = self.motion.sides, self._time - self._began
        self.correction = self.correction.corrected(alpha, alpha_d, sides, angles - alpha, variance, since)
        return self.correction.at(alpha, alpha_d, sides)

    def _measure_joints(self, angles: Array, sigma: Array) -> None:
        """Angles (N,), rad, one joint after the other; NaN where not seen."""
        layout = self.numbers.layout
        angles = angles - self.numbers.marker_offset
        angles = angles - self._learned(angles, sigma)
        for i in np.flatnonzero(np.isfinite(angles)):
            alpha, pose_error = layout.alpha.start + i, layout.pose_error.start + i
            P = self.covariance
            by = P[alpha] + P[pose_error]
            variance = by[alpha] + by[pose_error] + sigma[i] ** 2
            innovation = angles[i] - self.state[alpha] - self.state[pose_error]
            self.state = self.state + by * (innovation / variance)
            self.covariance = _symmetric(P - by[:, None] * (by / variance))


def _symmetric(P: Array) -> Array:
    return (P + P.T) / 2
