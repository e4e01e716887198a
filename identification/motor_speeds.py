"""Motor speeds within the rows of a log, by a smoother that knows the motors' equations.

Where a motor turns round, dry friction turns over within a row or two. Its speed then has a kink, and every step of the command
makes another; a spline through the counts rounds them all off, and friction computed from it is wrong for as long as the motor
turns round. What is smooth is the tension, t = F - friction(theta') - Ia (R/rd) theta'' of (43): commands and friction are known.
So the angles are sought that fit the counts and make that tension as smooth as its spectrum says, on half rows:

    sum ((theta - measured) / sigma)^2 + roughness |second difference of t|^2  ->  min

Without friction and commands this is a smoothing spline. Its cutoff follows from the tension's spectrum beside that of rounding.
Where cables rub on pulleys, friction depends on the tension itself: on that of a first estimate without it.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded
from scipy.ndimage import uniform_filter1d
from scipy.signal import welch

from identification.dataset.dataset import DataSet
from identification.dataset.half_row_speeds import HalfRowSpeeds, smoother_response
from identification.held_commands import mean_held_force
from mechanism.arm import Arm
from mechanism.cable_lengths import wrap_angles
from mechanism.laws import MotorMotion
from mechanism.machine import Machine

Array = NDArray[np.float64]

STEPS_PER_ROW = 2
"""steps of the angles within a row of the log: friction is taken at each step's mean speed"""
LOWEST_CUTOFF_HZ = 4.0
"""Hz: the lowest cutoff that is tried (docs/thresholds.md)"""
HIGHEST_CUTOFF_HZ = 25.0
"""Hz: the highest one (docs/thresholds.md)"""
_SPECTRUM_S = 2.0
"""s: length of the stretches whose spectra are averaged (docs/thresholds.md)"""
_SMOOTHED_BINS = 9
_MAX_ITERATIONS = 8
_TOLERANCE_RAD_S = 1e-3
"""rad/s: a step of Gauss and Newton that changes no speed by more was the last (docs/thresholds.md)"""


def with_motor_speeds(data: DataSet, machine: Machine, delay: float, draws: int = 0) -> DataSet:
    """A data set with its motors' speeds within the rows.

    machine: laws of friction and of the command, with their numbers.
    delay: s, by which forces act later than the log says; draws: how often the speeds' error is drawn.
    """
    state = data.state
    theta, f = state.matrix("theta"), state.matrix("f")
    step = float(np.mean(np.diff(state.time)))
    wrap = wrap_angles(data.arm, state.matrix("alpha")) if machine.rubs_under_tension else None
    return replace(
        data, speeds=motor_speeds(data.arm, machine, theta, f, step, data.neck.count_angles, delay, draws, wrap)
    )


def motor_speeds(
    arm: Arm,
    machine: Machine,
    theta: Array,
    f: Array,
    step: float,
    count: Array,
    delay: float = 0.0,
    draws: int = 0,
    wrap: Array | None = None,
) -> HalfRowSpeeds:
    """Speeds of the motors within the rows of a log. Their error is drawn by rounding the estimate anew and smoothing that.

    theta: (T, M), rad, as measured, at rows `step` s apart; f: (T, M), N, each from its row and a delay, s, on; count: of
    each encoder, (M,), rad; wrap: of each cable around its pulleys, (T, M), rad, where the machine rubs there.
    """
    force = machine.acting_force(f, step)
    inertia = np.broadcast_to(arm.motor_inertia / arm.drum, (arm.M,))
    grid = (len(theta) - 1) * STEPS_PER_ROW + 1
    rows = np.arange(len(theta)) * STEPS_PER_ROW
    # every motor's numbers in one piece
    start = np.stack([np.interp(np.arange(grid), rows, column) for column in theta.T]).T
    held = mean_held_force(force, np.arange(grid) / STEPS_PER_ROW - delay / step)
    slack = np.zeros_like(held)
    drive = _Drive(machine, held, inertia, step / STEPS_PER_ROW, MotorMotion(slack, slack, slack))
    sigma, cutoff = count / np.sqrt(12), np.full(arm.M, HIGHEST_CUTOFF_HZ)
    # with the widest cutoff first: it shows down to which frequency the tension can be told from rounding
    wide = drive.smoothed(start, theta, sigma, cutoff)
    if wrap is not None and machine.rubs_under_tension:
        drive = drive.rubbing(drive.tension(wide), wrap)
        wide = drive.smoothed(wide, theta, sigma, cutoff)
    cutoff = _cutoff(drive.tension(wide), inertia, sigma, step)
    angles = drive.smoothed(wide, theta, sigma, cutoff)
    mean = _half_row_speeds(angles, step)
    rng, errors = np.random.default_rng(0), []
    for _ in range(draws):
        # a motor that creeps within a count is counted alike for long: its rounding is no white noise
        phase = rng.uniform(-0.5, 0.5, arm.M)
        counted = count * (np.round(angles[::STEPS_PER_ROW] / count + phase) - phase)
        drawn = drive.smoothed(angles, counted, sigma, cutoff)
        errors.append(_half_row_speeds(drawn, step) - mean)
    return HalfRowSpeeds(mean, cutoff, sigma, np.array(errors).reshape(draws, *mean.shape))


def _half_row_speeds(angles: Array, step: float) -> Array:
    """Mean speeds before and after each row, (2, T, M), of angles on half rows."""
    speed = np.diff(angles, axis=0) * STEPS_PER_ROW / step
    before, after = np.concatenate([speed[:1], speed[1::2]]), np.concatenate([speed[::2], speed[-1:]])
    return np.stack([before.T, after.T]).swapaxes(1, 2)


def _cutoff(tension: Array, inertia: Array, sigma: Array, step: float) -> Array:
    """Cutoff of each motor, (M,), Hz, that leaves least of its speed wrong.

    A lower one smooths away what is in the tension, a higher one lets rounding in: both as the tension's spectrum says, which at
    high frequencies is rounding's alone.
    """
    rate = STEPS_PER_ROW / step
    hertz, power = welch(tension, rate, nperseg=min(len(tension), int(_SPECTRUM_S * rate)), axis=0, detrend="linear")
    inside = (hertz > 0) & (hertz <= HIGHEST_CUTOFF_HZ)
    hertz, power = hertz[inside][:, None], power[inside]
    rounding = inertia**2 * (2 * np.pi * hertz) ** 4 * 2 * sigma**2 * step
    to_speed = 1 / (2 * np.pi * hertz * inertia) ** 2
    choices = np.arange(LOWEST_CUTOFF_HZ, HIGHEST_CUTOFF_HZ + 0.1, 0.5)
    passed = smoother_response(hertz, choices[:, None, None])
    # what chance leaves of rounding in one frequency and takes from the next must not count as motion
    own = np.maximum(uniform_filter1d(power / passed[-1] ** 2 - rounding, _SMOOTHED_BINS, axis=0), 0.0)
    let_in = np.sum(passed**2 * rounding * to_speed, axis=1)
    error = let_in + np.sum((1 - passed) ** 2 * own * to_speed, axis=1)
    return choices[np.argmin(error, axis=0)]


@dataclass(frozen=True)
class _Drive:
    """What turns the motors, on G angles that are half a row apart."""

    machine: Machine
    held: Array
    """forces between the angles, (G - 1, M), N"""
    inertia: Array
    """Ia (R/rd), (M,)"""
    length: float
    """s, from angle to angle"""
    rubs: MotorMotion
    """under which tension, and wound how far, cables rub on their pulleys between the angles; its speeds are not used"""

    def rubbing(self, tension: Array, wrap: Array) -> "_Drive":
        """The same under a tension at the inner angles, (G - 2, M), N, and wound by `wrap`, (T, M), rad, at the rows."""
        pulled = np.concatenate([tension[:1], (tension[:-1] + tension[1:]) / 2, tension[-1:]])
        rows, between = np.arange(len(wrap)), (np.arange(len(self.held)) + 0.5) / STEPS_PER_ROW
        wound = np.stack([np.interp(between, rows, column) for column in wrap.T], axis=-1)
        return replace(self, rubs=MotorMotion(np.zeros_like(pulled), np.maximum(pulled, 0.0), wound))

    def tension(self, angles: Array) -> Array:
        """At the inner angles, (G - 2, M), N."""
        net = self.held - self.machine.friction(self._turning(angles))
        return (net[:-1] + net[1:]) / 2 - self.inertia * np.diff(angles, 2, axis=0) / self.length**2

    def _turning(self, angles: Array) -> MotorMotion:
        memory = self.machine.memory_on_path(angles) if self.machine.remembers_path else self.rubs.memory
        return replace(self.rubs, theta_d=np.diff(angles, axis=0) / self.length, memory=memory)

    def smoothed(self, start: Array, measured: Array, sigma: Array, cutoff: Array) -> Array:
        """Angles (G, M), rad, by Gauss and Newton's steps from `start`; measured: at the rows, (T, M), rad."""
        angles, row = start, self.length * STEPS_PER_ROW
        # a motor whose tension alone counts follows its angles up to the cutoff: |inertia w^4|^2 roughness = 1 / (sigma^2 row)
        root = np.sqrt(self.length / (sigma**2 * row)) / ((2 * np.pi * cutoff) ** 4 * self.inertia) / self.length**2
        for _ in range(_MAX_ITERATIONS):
            turning = self._turning(angles)
            by_speed = self.machine.friction_slope(turning) / self.length
            by_path = self.machine.friction_by_path(turning) / 2
            by_start, by_end = by_path - by_speed, by_path + by_speed
            rough = root * np.diff(self.tension(angles), 2, axis=0)
            change = np.empty_like(angles)
            for j in range(angles.shape[1]):
                by_angles = root[j] * _roughness_by_angles(
                    by_start[:, j], by_end[:, j], self.inertia[j] / self.length**2
                )
                change[:, j] = _step(by_angles, rough[:, j], measured[:, j] - angles[::STEPS_PER_ROW, j], sigma[j])
            angles = angles + change
            if np.abs(np.diff(change, axis=0)).max() < _TOLERANCE_RAD_S * self.length:
                break
        return angles


def _roughness_by_angles(by_start: Array, by_end: Array, inertia: float) -> Array:
    """Derivatives of the tension's second differences by the five angles that each depends on, (5, G - 4).

    by_start, by_end: slopes of friction by the angle where each step begins and ends, (G - 1,); inertia: Ia (R/rd) over the step
    squared.
    """
    by_angles = np.stack(
        [-by_start[:-1] / 2 - inertia, 2 * inertia - (by_end[:-1] + by_start[1:]) / 2, -by_end[1:] / 2 - inertia]
    )
    out = np.zeros((5, by_angles.shape[1] - 2))
    for place, weight in enumerate((1.0, -2.0, 1.0)):
        out[place : place + 3] += weight * by_angles[:, place : by_angles.shape[1] - 2 + place]
    return out


def _step(by_angles: Array, rough: Array, misfit: Array, sigma: float) -> Array:
    """Gauss and Newton's change of the angles, (G,)."""
    count = len(rough) + 4
    band, gradient = np.zeros((5, count)), np.zeros(count)
    band[0, ::STEPS_PER_ROW] = 1 / sigma**2
    gradient[::STEPS_PER_ROW] = misfit / sigma**2
    for a, row in enumerate(by_angles):
        gradient[a : a + len(rough)] -= row * rough
        for b in range(a + 1):
            band[a - b, b : b + len(rough)] += row * by_angles[b]
    return solveh_banded(band, gradient, lower=True, check_finite=False)
