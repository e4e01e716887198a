"""Joint angles from motor angles and forces, row by row: an extended Kalman filter on the equations of motion.

Each row predicts the state over the time since the row before, under the force that acted in it, by a linearly implicit step
around the step's middle, and then takes the counted motor angles for what they are worth. Cables and arm are far stiffer than a
row is short: the step is L-stable. The state is that of StateLayout; the angle of a joint is what its equations say plus the
pose's error.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.model_file import Model
from mechanism.description import Neck
from observation.code import python_function
from observation.equations import Equations, traced_equations
from observation.filter_numbers import (
    GAMMA,
    LAG_SIGMA_S,
    POSE_RATE_HZ,
    POSE_TIME_S,
    FilterNumbers,
    filter_numbers,
)
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MAX_STEP_S = 4e-3
"""s: longer rows are gone through in several steps (docs/thresholds.md)"""
MAX_GAP_S = 1.0
"""s without a row, after which the observer begins anew (docs/thresholds.md)"""
_LEFT_RANGE = "is it this arm's model and neck.yaml, and are motors counted from the same zero?"
_MEMORY = ("state", "covariance", "_speed_d", "_force", "_acting", "_time", "_began")
NEWTON_STEPS, MAX_NEWTON_RAD, AT_REST_RAD = 60, 0.1, 1e-10
RANGE_RAD = 2.8
"""of a joint's angle, beyond which the mechanism has no pose"""


@dataclass(frozen=True)
class Observed:
    """Joint angles (N,), rad, their rates, rad/s, and the covariance of both, (2 N, 2 N)."""

    alpha: Array
    alpha_d: Array
    covariance: Array


class Observer:
    """Joint angles of one arm, row by row of its controller.

    neck: the arm's description. model: of `xneck identify` or `xneck diagnose`. step_s: s, from row to row, where rows come without
    their time. Raises Refused where the model was not identified for this, or a law cannot be written as code.

    >>> import xneck
    >>> data = xneck.read_dataset("monday.mcap")
    >>> observer = xneck.Observer(data.neck, xneck.read_model("model.yaml"))
    >>> theta, f = data.state.matrix("theta"), data.state.matrix("f")
    >>> alpha, alpha_d, covariance = observer.step(theta[0], f[0])  # each control step: rad, rad/s; (2 N, 2 N)
    >>> alpha.shape, covariance.shape
    ((3,), (6, 6))
    """

    def __init__(self, neck: Neck, model: Model, step_s: float = 2e-3) -> None:
        self.numbers: FilterNumbers = filter_numbers(neck, model)
        self.equations: Equations = traced_equations(self.numbers.machine)
        self.step_s = step_s
        e = self.equations
        self._evaluated = python_function(
            [[v.name for v in e.state], [v.name for v in e.force], [e.time.name]], e.outputs
        )
        layout = self.numbers.layout
        n, size = layout.N, layout.size
        self._split = np.cumsum([n * n, len(e.rates), len(e.derivatives)])
        rows, columns = np.array(e.places).T
        self._flat = rows * size + columns
        self._by_state = np.zeros((len(e.rates), size))
        self._identity = np.eye(size)
        J = np.zeros((size, size))
        J[layout.alpha, layout.alpha_d] = np.eye(n)
        J[layout.theta, layout.theta_d] = np.eye(layout.M)
        J -= np.diag(self.numbers.decay)
        self._J = J
        self._bounded = bool(np.isfinite(self.numbers.memory_bound).any())
        self._upper = np.triu_indices(n)
        self.restart()

    def restart(self) -> None:
        """Forgets all rows: the next one is the first."""
        self.state = self.numbers.start.copy()
        self.covariance = np.diag(self.numbers.start_sigma**2)
        self._speed_d = np.zeros(self.numbers.layout.size)
        self._force: Array | None = None
        self._acting: list[Array | None] = [None] * len(self.numbers.machine.laws)
        self._time = 0.0
        self._began = 0.0
        self.transition: Array | None = None
        """from the row before to this one, (size, size); None where the observer began"""
        self.predicted, self.predicted_covariance = self.state, self.covariance
        self.innovation = np.zeros(self.numbers.layout.M)
        self.innovation_covariance = np.diag(self.numbers.theta_sigma**2)

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

        theta: motor angles (M,), rad, in the signs of neck.yaml. f: forces (M,), N at the cable, that are told to the motors from
        this row on. time: s, of the row. angles: of the joints at this row by a camera, (N,), rad, NaN where not seen, with their
        sigma: also the pose where the observer begins. Raises Refused where a number is not finite.
        """
        theta, f = np.asarray(theta, dtype=float), np.asarray(f, dtype=float)
        if not (np.isfinite(theta).all() and np.isfinite(f).all()):
            raise Refused("observe", "a motor angle or force is not finite", "leave such rows out")
        first = self._force is None
        at = (0.0 if first else self._time + self.step_s) if time is None else float(time)
        if not first and at - self._time > MAX_GAP_S:
            self._begin_anew()
            first = True
        if first:
            self.transition = None
            self._began = at if self._force is None else self._began
            self._start(theta, angles)
        else:
            self._predict(at - self._time)
            self._measure_motors(theta)
        self._time = at
        self._force = self._acting_force(f, self.step_s)
        if angles is not None:
            if sigma is None:
                raise Refused("observe", "angles came without their sigma", "say how well they are known, in rad")
            self._measure_joints(np.asarray(angles, dtype=float), np.broadcast_to(np.asarray(sigma), angles.shape))
        layout = self.numbers.layout
        if not (np.isfinite(self.state).all() and np.abs(self.state[layout.alpha]).max() < np.pi):
            raise Refused("observe", f"the arm leaves the range of its mechanisms at {at:.3f} s", _LEFT_RANGE)
        out = self.observed
        return out.alpha, out.alpha_d, out.covariance

    @property
    def memory(self) -> dict[str, Any]:
        """All that a row leaves for the next; setting it goes back to that row."""
        return {name: getattr(self, name) for name in _MEMORY}

    @memory.setter
    def memory(self, values: dict[str, Any]) -> None:
        for name in _MEMORY:
            setattr(self, name, values[name])

    @property
    def observed(self) -> Observed:
        """The joints at the last row."""
        return self.observed_of(self.state, self.covariance)

    def observed_of(self, s: Array, P: Array) -> Observed:
        """The joints of a state (size,) with its covariance."""
        layout = self.numbers.layout
        a, v, b = layout.alpha, layout.alpha_d, layout.pose_error
        n = layout.N
        covariance = np.empty((2 * n, 2 * n))
        cross = P[a, b]
        covariance[:n, :n] = P[a, a] + P[b, b] + cross + cross.T
        covariance[:n, n:] = P[a, v] + P[b, v]
        covariance[n:, :n] = covariance[:n, n:].T
        covariance[n:, n:] = P[v, v] + (2 * np.pi * POSE_RATE_HZ) ** 2 * P[b, b]
        return Observed(s[a] + s[b], s[v].copy(), covariance)

    @property
    def friction_error(self) -> Array:
        """What each motor's law does not say at the last row, (M,), N."""
        return self.state[self.numbers.layout.friction_error].copy()

    def _begin_anew(self) -> None:
        """After a gap of the log, with pre-elongations as they were."""
        layout = self.numbers.layout
        x0, of_x0 = self.state[layout.x0].copy(), self.covariance[layout.x0, layout.x0].copy()
        force, began = self._force, self._began
        self.restart()
        self._force, self._began = force, began
        self.state[layout.x0], self.covariance[layout.x0, layout.x0] = x0, of_x0

    def _acting_force(self, f: Array, step: float) -> Array:
        for place, law in enumerate(self.numbers.machine.laws):
            f = law.next_force(self.numbers.machine.values, f, self._acting[place], step)
            self._acting[place] = f
        return f

    def _start(self, theta: Array, angles: Array | None) -> None:
        """At rest where the cables pull the arm to, from a told pose on."""
        layout = self.numbers.layout
        a, x0, s = layout.alpha, layout.x0, self.state
        s[layout.theta] = theta
        if angles is not None:
            s[a] = np.where(np.isfinite(angles), angles, 0.0)
        told = s[a].copy()
        n = layout.N
        slope = np.eye(n)
        for _ in range(NEWTON_STEPS):
            _, rates, _ = self._formed(s, np.zeros(layout.M), 0.0)
            slope = self._by_state[:n, a]
            change = -np.linalg.solve(slope, rates[:n]) if np.linalg.det(slope) else np.zeros(n)
            change *= min(1.0, MAX_NEWTON_RAD / max(float(np.max(np.abs(change))), 1e-300))
            s[a] += change
            if np.max(np.abs(change)) < AT_REST_RAD:
                break
        if not np.all(np.abs(s[a]) < RANGE_RAD):
            s[a] = told
        by_x0 = -np.linalg.solve(slope, self._by_state[:n, x0])
        P = self.covariance
        P[a, x0] = by_x0 @ P[x0, x0]
        P[x0, a] = P[a, x0].T
        P[a, a] += by_x0 @ P[x0, x0] @ by_x0.T

    def _formed(self, state: Array, force: Array, since: float) -> tuple[Array, Array, Array]:
        """Mass matrix, rates and tensions; derivatives of the rates by the state go to `_by_state`."""
        try:
            values = np.array(self._evaluated(state.tolist(), force.tolist(), (since,)))
        except (ArithmeticError, ValueError) as error:  # roots of what is negative, beyond the range of a mechanism
            raise Refused(
                "observe", f"the arm leaves the range of its mechanisms at {since:.3f} s", _LEFT_RANGE
            ) from error
        end_of_mass, end_of_rates, end_of_derivatives = self._split
        n = self.numbers.layout.N
        self._by_state.ravel()[self._flat] = values[end_of_rates:end_of_derivatives]
        return values[:end_of_mass].reshape(n, n), values[end_of_mass:end_of_rates], values[end_of_derivatives:]

    def _predict(self, interval: float) -> None:
        steps = max(1, int(np.ceil(interval / MAX_STEP_S)))
        self.transition = None
        for step in range(steps):
            F = self._predicted_step(interval / steps, self._time + (step + 0.5) * interval / steps - self._began)
            self.transition = F if self.transition is None else F @ self.transition
        self.predicted, self.predicted_covariance = self.state, self.covariance

    def _predicted_step(self, h: float, since: float) -> Array:
        """Goes on by h; returns the transition."""
        layout, b = self.numbers.layout, self.numbers.layout.pose_error
        change, F, V, noise = self.linearised(h, since)
        P = F @ self.covariance @ F.T + (V * (self.numbers.noise * h)) @ V.T
        P[b, b] += noise * (2 * h / POSE_TIME_S)
        self.covariance = (P + P.T) / 2
        self.state = self.state + change
        self._speed_d[layout.alpha_d], self._speed_d[layout.theta_d] = (
            change[layout.alpha_d] / h,
            change[layout.theta_d] / h,
        )
        if self._bounded:
            bound = self.numbers.memory_bound
            self.state[layout.memory] = np.clip(self.state[layout.memory], -bound, bound)
        return F

    def linearised(self, h: float, since: float) -> tuple[Array, Array, Array, Array]:
        """Change of the state over h, its derivative by the state, what noise is multiplied by, and the pose error's covariance."""
        layout = self.numbers.layout
        n, m, s = layout.N, layout.M, self.state
        a, v, theta, w = layout.alpha, layout.alpha_d, layout.theta, layout.theta_d
        half = self._speed_d * (h / 2)
        half[a], half[theta] = s[v] * (h / 2), s[w] * (h / 2)
        middle = s + half
        assert self._force is not None
        mass, rates, tension = self._formed(middle, self._force, since)
        solved = np.linalg.solve(mass, np.concatenate([self._by_state[:n], rates[:n, None]], axis=1))
        J = self._J
        J[v] = solved[:, :-1]
        J[w] = self._by_state[n : n + m]
        g = -self.numbers.decay * middle
        g[a], g[v], g[theta], g[w] = middle[v], solved[:, -1], middle[w], rates[n : n + m]
        if layout.S:
            J[layout.memory] = self._by_state[n + m :]
            g[layout.memory] = rates[n + m :]
        g -= J @ half
        hJ = h * J
        V = np.linalg.inv(self._identity - GAMMA * hJ)
        V2 = V @ V
        change = V2 @ (h * (g - GAMMA**2 * (hJ @ g)))
        F = V2 @ (self._identity + (1 - 2 * GAMMA) * hJ)
        return change, F, V, self._pose_noise(middle, tension)

    def _pose_noise(self, state: Array, tension: Array) -> Array:
        """Covariance of the pose's error, (N, N), rad^2."""
        layout, numbers = self.numbers.layout, self.numbers
        error = numbers.pose_error
        u = (state[layout.alpha] - error.middle) / error.half_range
        features = np.empty(len(error.factor))
        n = layout.N
        features[0], features[1 : n + 1], features[-1] = 1.0, u, (tension.mean() - error.tension[0]) / error.tension[1]
        features[n + 1 : -1] = (u[:, None] * u)[self._upper]
        A = (features @ error.factor.reshape(len(features), -1)).reshape(n, -1)
        lag = LAG_SIGMA_S * state[layout.alpha_d]
        return A @ A.T + np.diag(numbers.pose_floor**2) + lag[:, None] * lag

    def _measure_motors(self, theta: Array) -> None:
        at, P = self.numbers.layout.theta, self.covariance
        e = theta - self.state[at]
        S = P[at, at] + np.diag(self.numbers.theta_sigma**2)
        K = np.linalg.solve(S, P[at]).T
        self.state = self.state + K @ e
        P = P - K @ P[at]
        self.covariance = (P + P.T) / 2
        self.innovation, self.innovation_covariance = e, S

    def _measure_joints(self, angles: Array, sigma: Array) -> None:
        """One joint after the other."""
        layout = self.numbers.layout
        for i in range(layout.N):
            if not np.isfinite(angles[i]):
                continue
            P = self.covariance
            by = P[layout.alpha.start + i] + P[layout.pose_error.start + i]
            variance = by[layout.alpha.start + i] + by[layout.pose_error.start + i] + sigma[i] ** 2
            s = self.state
            e = angles[i] - s[layout.alpha.start + i] - s[layout.pose_error.start + i]
            self.state = s + by * (e / variance)
            P = P - by[:, None] * (by / variance)
            self.covariance = (P + P.T) / 2
