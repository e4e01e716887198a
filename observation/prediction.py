"""The filter's prediction: the equations of motion over one step, with what they do to the covariance.

The step is linearly implicit about its middle: cables and arm are far stiffer than a row of the log is short, and exp(z) is taken
as (1 + (1 - 2 gamma) z) / (1 - gamma z)^2, which is of order 2 and L-stable (Hairer and Wanner, Solving Ordinary Differential
Equations II, IV.3).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from observation.evaluated_equations import EvaluatedEquations
from observation.filter_numbers import LAG_SIGMA_S, POSE_TIME_S, FilterNumbers

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


class Prediction:
    """Steps of one arm with one model."""

    def __init__(self, numbers: FilterNumbers, equations: EvaluatedEquations) -> None:
        self._numbers, self._equations = numbers, equations
        layout = numbers.layout
        self._identity = np.eye(layout.size)
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
        e = self._equations.at(middle, force, elapsed)
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
        if layout.S:
            J[layout.memory], rate[layout.memory] = e.by_state[n + m :], e.rates[n + m :]
        rate -= J @ half
        hJ = h * J
        V = np.linalg.inv(self._identity - GAMMA * hJ)
        V2 = V @ V
        return PredictedStep(
            h=h,
            change=V2 @ (h * (rate - GAMMA**2 * (hJ @ rate))),
            transition=V2 @ (self._identity + (1 - 2 * GAMMA) * hJ),
            noise_gain=V,
            pose_covariance=self._pose_covariance(middle, e.tension),
        )

    def noise(self, step: PredictedStep) -> Array:
        """Covariance that noise adds over a step, (size, size)."""
        V, pose_error = step.noise_gain, self._numbers.layout.pose_error
        Q = (V * (self._numbers.noise * step.h)) @ V.T
        Q[pose_error, pose_error] += step.pose_covariance * (2 * step.h / POSE_TIME_S)
        return Q

    def _pose_covariance(self, state: Array, tension: Array) -> Array:
        """A A^T of PoseError, with the least of each angle and what a clock's lag does to moving joints, (N, N), rad^2."""
        numbers, layout = self._numbers, self._numbers.layout
        A = numbers.pose_error.at(state[layout.alpha], float(tension.mean()))
        lag = LAG_SIGMA_S * state[layout.alpha_d]
        return A @ A.T + np.diag(numbers.pose_floor**2) + lag[:, None] * lag
