"""Motor speeds within the rows of a log, by a smoother that knows the motors' equations.

Where a motor turns round, dry friction turns over within a row or two. Its speed then has a kink, and every step of the command
makes another; a spline through the counts rounds them all off, and friction computed from it is wrong for as long as the motor
turns round. What is smooth is the tension, t = F - friction(theta') - Ia (R/rd) theta'' of (43): commands and friction are known.
So the angles are sought that fit the counts and make that tension as smooth as its spectrum says, on half rows:

    sum ((theta - measured) / sigma)^2 + roughness |second difference of t|^2  ->  min

Without friction and commands this is a smoothing spline. Its cutoff follows from the tension's spectrum beside that of rounding.
Where cables rub on pulleys, friction depends on the tension itself: on that of a first estimate without it.
"""

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.signal import welch

from identification.dataset.dataset import DataSet
from identification.dataset.half_row_speeds import HalfRowSpeeds, smoother_response
from identification.held_commands import mean_held_force
from identification.motor_drive import STEPS_PER_ROW, DrivenMotion, MotorDrive
from mechanism.arm import Arm
from mechanism.cable_lengths import wrap_angles
from mechanism.laws import MotorMotion
from mechanism.machine import Machine

Array = NDArray[np.float64]

LOWEST_CUTOFF_HZ = 4.0
"""Hz: the lowest cutoff that is tried (docs/thresholds.md)"""
HIGHEST_CUTOFF_HZ = 25.0
"""Hz: the highest one (docs/thresholds.md)"""
_SPECTRUM_S = 2.0
"""s: length of the stretches whose spectra are averaged (docs/thresholds.md)"""
_SMOOTHED_BINS = 9


def with_motor_speeds(data: DataSet, machine: Machine, delay: float, draws: int = 0) -> DataSet:
    """A data set with its motors' speeds within the rows.

    machine: laws of friction and of the command, with their numbers.
    delay: s, by which forces act later than the log says; draws: how often the speeds' error is drawn, once it is asked for.
    """
    state = data.state
    theta, f = state.matrix("theta"), state.matrix("f")
    step = float(np.mean(np.diff(state.time)))
    wrap = wrap_angles(data.arm, state.matrix("alpha")) if machine.rubs_under_tension else None
    return replace(data, speeds=motor_speeds(data.arm, machine, theta, f, step, data.count_angles, delay, draws, wrap))


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
    """Speeds of the motors within the rows of a log. Their error is drawn, where asked for, by rounding the estimate anew.

    theta: (T, M), rad, as measured, at rows `step` s apart; f: (T, M), N, each from its row and a delay, s, on; count: of
    each encoder, (M,), rad; wrap: of each cable around its pulleys, (T, M), rad, where the machine rubs there.
    """
    machine = machine.of_motors
    force = machine.acting_force(f, step)
    inertia = np.broadcast_to(arm.motor_inertia / arm.drum, (arm.M,))
    grid = (len(theta) - 1) * STEPS_PER_ROW + 1
    rows = np.arange(len(theta)) * STEPS_PER_ROW
    # every motor's numbers in one piece
    start = np.stack([np.interp(np.arange(grid), rows, column) for column in theta.T]).T
    held = mean_held_force(force, np.arange(grid) / STEPS_PER_ROW - delay / step)
    slack = np.zeros_like(held)
    drive = MotorDrive(machine, held, inertia, step / STEPS_PER_ROW, MotorMotion(slack, slack, slack))
    sigma, cutoff = count / np.sqrt(12), np.full(arm.M, HIGHEST_CUTOFF_HZ)
    # with the widest cutoff first: it shows down to which frequency the tension can be told from rounding
    wide = drive.smoothed(start, machine.memory_start, theta, sigma, cutoff)
    if wrap is not None and machine.rubs_under_tension:
        drive = drive.rubbing(wide.tension, wrap)
        wide = drive.smoothed(wide.angles, wide.memory_start, theta, sigma, cutoff)
    cutoff = _cutoff(wide.tension, inertia, sigma, step)
    smooth = drive.smoothed(wide.angles, wide.memory_start, theta, sigma, cutoff)
    drawn = partial(_drawn_errors, drive, smooth, count, cutoff, draws) if draws else None
    return HalfRowSpeeds(_half_row_speeds(smooth.angles, step), cutoff, sigma, drawn)


def _drawn_errors(drive: MotorDrive, smooth: DrivenMotion, count: Array, cutoff: Array, draws: int) -> Array:
    """Errors of half rows' speeds, (draws, 2, T, M), rad/s: those of the estimate, rounded to counts anew and smoothed."""
    rng, errors, step = np.random.default_rng(0), [], drive.length * STEPS_PER_ROW
    mean = _half_row_speeds(smooth.angles, step)
    for _ in range(draws):
        # a motor that creeps within a count is counted alike for long: its rounding is no white noise
        phase = rng.uniform(-0.5, 0.5, len(count))
        counted = count * (np.round(smooth.angles[::STEPS_PER_ROW] / count + phase) - phase)
        drawn = drive.smoothed(smooth.angles, smooth.memory_start, counted, count / np.sqrt(12), cutoff)
        errors.append(_half_row_speeds(drawn.angles, step) - mean)
    return np.array(errors)


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
