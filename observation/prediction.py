"""The filter's prediction: the equations of motion over one step, with what they do to the covariance.

The step is linearly implicit about its middle: cables and arm are far stiffer than a row of the log is short, and exp(z) is taken
as (1 + (1 - 2 gamma) z) / (1 - gamma z)^2, which is of order 2 and L-stable (Hairer and Wanner, Solving Ordinary Differential
Equations II, IV.3).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechanism.friction import HELD_VARIANCE
from observation.evaluated_equations import EvaluatedEquations, EvaluatedRates
from observation.filter_numbers import FilterNumbers
from observation.pose_time import POSE_TIME_S

Array = NDArray[np.float64]

GAMMA = 1 - 1 / np.sqrt(2)
"""of the step, for which it is L-stable"""


@dataclass(frozen=True)
class PredictedStep:
    """A step of h s from one state."""

    h: float
    change: Array
    """of the state, (size,)"""
    transition: Array
    """F: derivative of the state after the step by that before it, (size, size)"""
    noise_gain: Array
    """V, (size, size): noise in the state's rates acts as V noise"""
    pose_covariance: Array
    """of the pose's error, where it is in equilibrium, (N, N), rad^2"""
    beyond: Array
    """by how much motion would have led memory variables beyond their bounds, (M S,)"""


class Prediction:
    """Steps of one arm with one model."""

    def __init__(self, numbers: FilterNumbers, equations: EvaluatedEquations) -> None:
        self._numbers, self.equations = numbers, equations
        layout = numbers.layout
        self._identity = np.eye(layout.size)
        self._pose_floor = np.diag(numbers.pose_floor**2)
        # what no equation of motion is in: angles follow their rates, errors decay
        self._constant_jacobian = -np.diag(numbers.decay)
        self._constant_jacobian[layout.alpha, layout.alpha_d] = np.eye(layout.N)
        self._constant_jacobian[layout.theta, layout.theta_d] = np.eye(layout.M)

    def step(self, state: Array, acceleration: Array, force: Array, h: float, elapsed: float) -> PredictedStep:
        """From a state (size,) over h s, under acting forces (M,), N.

        acceleration: the last step's, (size,), in the places of the speeds: they say where the middle of this step is, which is
        `elapsed` s after the recording began. Raises Refused where a mechanism has no such pose.
        """
        layout, numbers = self._numbers.layout, self._numbers
        n, m = layout.N, layout.M
        alpha, alpha_d, theta, theta_d = layout.alpha, layout.alpha_d, layout.theta, layout.theta_d
        half = acceleration * (h / 2)
        half[alpha], half[theta] = state[alpha_d] * (h / 2), state[theta_d] * (h / 2)
        middle = state + half
        e = self.equations.at(middle, force, elapsed)
        solved = np.linalg.solve(e.mass, np.concatenate([e.by_state[:n], e.rates[:n, None]], axis=1))
        J = self._constant_jacobian.copy()
        J[alpha_d] = solved[:, :-1]
        J[theta_d] = e.by_state[n : n + m]
        rate = -numbers.decay * middle
        rate[alpha], rate[alpha_d], rate[theta], rate[theta_d] = (
            middle[alpha_d],
            solved[:, -1],
            middle[theta_d],
            e.rates[n : n + m],
        )
        memory_d = e.rates[n + m :]
        held = middle[layout.memory] * np.sign(memory_d) >= numbers.memory_bound
        if layout.S:
            J[layout.memory] = np.where(held[:, None], 0.0, e.by_state[n + m :])
            rate[layout.memory] = np.where(held, 0.0, memory_d)
        rate -= J @ half
        hJ = h * J
        V = np.linalg.inv(self._identity - GAMMA * hJ)
        V2 = V @ V
        change = V2 @ (h * (rate - GAMMA**2 * (hJ @ rate)))
        led_to = np.abs(state[layout.memory] + change[layout.memory])
        return PredictedStep(
            h=h,
            change=change,
            transition=V2 @ (self._identity + (1 - 2 * GAMMA) * hJ),
            noise_gain=V,
            pose_covariance=self._pose_covariance(middle, e),
            beyond=np.where(held, h * np.abs(memory_d), np.maximum(led_to - numbers.memory_bound, 0.0)),
        )

    def noise(self, step: PredictedStep) -> Array:
        """Covariance that noise adds over a step, (size, size)."""
        V, pose_error = step.noise_gain, self._numbers.layout.pose_error
        Q = (V * (self._numbers.noise * step.h)) @ V.T
        Q[pose_error, pose_error] += step.pose_covariance * (2 * step.h / POSE_TIME_S)
        return Q

    def pose_covariance_at(self, state: Array) -> Array:
        """Covariance of the pose's error in a state (size,) that no motion led to, (N, N), rad^2."""
        return self._pose_covariance(state, self.equations.at(state, np.zeros(self._numbers.layout.M), 0.0))

    def _pose_covariance(self, state: Array, e: EvaluatedRates) -> Array:
        """A A^T of PoseError, what the fit left of each angle, and what friction holds, (N, N), rad^2."""
        numbers, layout = self._numbers, self._numbers.layout
        motion = (state[layout.alpha_d], e.elongation_d, state[layout.sides])
        A = numbers.pose_error.at(state[layout.alpha], float(e.tension.mean()), *motion)
        covariance = A @ A.T + self._pose_floor
        return covariance + _held_covariance(e, layout.alpha) if e.held.any() else covariance


def _held_covariance(e: EvaluatedRates, alpha: slice) -> Array:
    """Of the angles, (N, N), rad^2, by what dry friction holds at rest, which no law of speed tells.

    The arm gives way to it by its compliance on the cables, and stays where it stands."""
    stiffness = e.by_state[: len(e.held), alpha]
    if not np.linalg.det(stiffness):
        return np.zeros_like(stiffness)
    compliance = np.linalg.inv(stiffness)
    return (compliance * (HELD_VARIANCE * e.held)) @ compliance.T
