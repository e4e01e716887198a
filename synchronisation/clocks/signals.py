"""The log's signals as clocks use them: all through one low-pass, as curves that can be asked at any time.

Row n of a log holds the force from that row on, so the force at the row is the mean of the periods before and after it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline
from scipy.signal import butter, lfilter, sosfiltfilt

from identification.dataset.series import Series
from mechanism.arm import Arm
from mechanism.friction import dry, turning

Array = NDArray[np.float64]

CUTOFF = 20.0
"""Hz: above what cables and motors do, below where encoder counts swamp accelerations"""
SPEED_CUTOFF = 40.0
"""Hz: of the speed whose sign friction takes; filtering first and taking the sign after would blunt it"""
GRID = 100.0
"""Hz: rate at which the filtered signals are kept"""


@dataclass(frozen=True)
class LogSignals:
    """Curves over the log's time, each giving (..., M); forces in N, travel in m, speeds in rad/s."""

    time: Array
    """(G,), s, where the curves were sampled; they hold between its ends"""
    travel: BSpline
    """(rd/R) theta"""
    force: BSpline
    """n = f - Ia (R/rd) theta''"""
    command: BSpline
    """f"""
    inertial: BSpline
    """Ia (R/rd) theta''"""
    rubbing: BSpline
    """dry(theta')"""
    turning: BSpline
    """what friction gains where it turns over sooner"""
    speed: BSpline
    """theta'"""
    has_force: bool


def log_signals_of(arm: Arm, log: Series) -> LogSignals:
    """The signals of a log of equal steps; without columns f the force is that of inertia alone."""
    rate = (len(log) - 1) / float(log.time[-1] - log.time[0])
    theta, f = log.matrix("theta"), log.matrix("f")
    has_force = f.shape[1] == arm.M
    f = f if has_force else np.zeros_like(theta)
    held = (np.vstack([f[:1], f[:-1]]) + f) / 2
    smooth = low_pass(theta, rate, CUTOFF)
    theta_d = np.gradient(smooth, 1 / rate, axis=0)
    theta_dd = np.gradient(theta_d, 1 / rate, axis=0)
    sharp = np.gradient(low_pass(theta, rate, SPEED_CUTOFF), 1 / rate, axis=0)
    command, inertial = low_pass(held, rate, CUTOFF), arm.motor_inertia / arm.drum * theta_dd
    every = max(1, round(rate / GRID))
    time = log.time[::every]

    def curve(values: Array) -> BSpline:
        return cubic(time, values[::every])

    return LogSignals(
        time,
        curve(arm.drum * smooth),
        curve(command - inertial),
        curve(command),
        curve(inertial),
        curve(low_pass(dry(sharp), rate, CUTOFF)),
        curve(low_pass(turning(sharp), rate, CUTOFF)),
        curve(theta_d),
        has_force,
    )


def rewired(arm: Arm, signals: LogSignals, order: Sequence[int], sign: int) -> LogSignals:
    """The signals if the log's columns stood in another order (motor j's is column order[j]) and all motors turned by `sign`."""
    s = signals
    columns = list(order)
    inertial = sign * s.inertial(s.time)

    def curve(values: Array) -> BSpline:
        return cubic(s.time, values[:, columns])

    return LogSignals(
        s.time,
        curve(sign * s.travel(s.time)),
        curve(s.command(s.time) - inertial),
        curve(s.command(s.time)),
        curve(inertial),
        curve(sign * s.rubbing(s.time)),
        curve(sign * s.turning(s.time)),
        curve(sign * s.speed(s.time)),
        s.has_force,
    )


def cubic(time: Array, values: Array) -> BSpline:
    """Through samples (T, ...), in a form that keeps one number for each of them."""
    return make_interp_spline(time, values, k=3)


def low_pass(values: Array, rate: float, cutoff: float) -> Array:
    """Zero-phase Butterworth of order 4 along the first axis; cutoff and rate in Hz."""
    sos = butter(4, min(cutoff / (rate / 2), 0.95), output="sos")
    return sosfiltfilt(sos, values, axis=0, padlen=min(len(values) - 1, int(rate)))


def lagged(values: Array, step: float, tau: Array) -> Array:
    """`values` (T, M) as first-order elements of time constants tau (M,), s, follow them; they are straight between samples
    and rest at first."""
    out = values.copy()
    for j, ratio in enumerate(tau / step):
        if ratio < 1e-3:
            continue
        decay = np.exp(-1 / ratio)
        late = 1 - ratio * (1 - decay)
        weights = [late, 1 - decay - late]
        out[:, j], _ = lfilter(weights, [1, -decay], values[:, j], zi=[values[0, j] * (1 - late)])
    return out
