"""The log's signals as the clock's equations need them: through one low-pass filter, as splines over the log's time.

Row n of a log holds the force from that row on, so the force at the row is the mean of the periods before and after it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline

from identification.dataset.series import Series
from identification.filters import low_pass
from mechanism.arm import Arm
from mechanism.friction import dry, dry_by_log_cm

Array = NDArray[np.float64]

SIGNAL_CUTOFF_HZ = 20.0
"""Hz: above what cables and motors do, below where encoder counts swamp accelerations"""
FRICTION_SPEED_CUTOFF_HZ = 40.0
"""Hz: of the speed that dry friction is computed from; a lower one would blunt its reversals"""
LAW_STEP_S = 2e-3
"""s: rows that are further apart have laws averaged between them"""
GRID_HZ = 100.0
"""Hz: rate at which the filtered signals are kept"""


@dataclass(frozen=True)
class LogSignals:
    """Splines over the log's time, each giving (..., M)."""

    time: Array
    """(G,), s, log clock: where the splines were sampled; they hold between its ends"""
    travel: BSpline
    """(rd/R) theta, m"""
    force: BSpline
    """n = f - Ia (R/rd) theta'', N"""
    command: BSpline
    """f, N"""
    inertial: BSpline
    """Ia (R/rd) theta'', N"""
    dry_friction: BSpline
    """dry friction of 1 N, ratio"""
    friction_turnover: BSpline
    """slope of dry friction of 1 N by log cm, how soon it turns over, ratio"""
    speed: BSpline
    """theta', rad/s"""
    has_force: bool
    """whether the log holds forces; without them f is taken as zero"""


def log_signals_of(arm: Arm, log: Series) -> LogSignals:
    """The signals of a log of equal steps; without columns f the force is that of the motors' inertia alone."""
    rate = (len(log) - 1) / float(log.time[-1] - log.time[0])
    theta, f = log.matrix("theta"), log.matrix("f")
    has_force = f.shape[1] == arm.M
    f = f if has_force else np.zeros_like(theta)
    held = (np.vstack([f[:1], f[:-1]]) + f) / 2
    smooth = low_pass(theta, rate, SIGNAL_CUTOFF_HZ)
    theta_d = np.gradient(smooth, 1 / rate, axis=0)
    theta_dd = np.gradient(theta_d, 1 / rate, axis=0)
    friction_speed = np.gradient(low_pass(theta, rate, FRICTION_SPEED_CUTOFF_HZ), 1 / rate, axis=0)
    dry_friction, turnover = (_as_held(law, log.time, friction_speed) for law in (dry, dry_by_log_cm))
    command, inertial = low_pass(held, rate, SIGNAL_CUTOFF_HZ), arm.motor_inertia / arm.drum * theta_dd
    every = max(1, round(rate / GRID_HZ))
    time = log.time[::every]

    def curve(values: Array) -> BSpline:
        return cubic_spline(time, values[::every])

    return LogSignals(
        time=time,
        travel=curve(arm.drum * smooth),
        force=curve(command - inertial),
        command=curve(command),
        inertial=curve(inertial),
        dry_friction=curve(low_pass(dry_friction, rate, SIGNAL_CUTOFF_HZ)),
        friction_turnover=curve(low_pass(turnover, rate, SIGNAL_CUTOFF_HZ)),
        speed=curve(theta_d),
        has_force=has_force,
    )


def _as_held(law: Callable[[Array], Array], time: Array, speed: Array) -> Array:
    """A law of the speeds (T, M), rad/s, at the rows, (T, M): averaged over the periods before and after, as the force there is."""
    step = float(time[1] - time[0])
    parts = round(step / LAW_STEP_S)
    if parts < 2:
        return law(speed)
    curve = cubic_spline(time, speed)
    mean = np.zeros_like(speed)
    for part in (np.arange(2 * parts) + 0.5) / parts - 1:
        mean += law(curve(np.clip(time + part * step, time[0], time[-1])))
    return mean / (2 * parts)


def relabelled(signals: LogSignals, order: Sequence[int], sign: int) -> LogSignals:
    """The signals if motor j's column of the log were column order[j], and all motors counted theta by `sign` (1 or -1)."""
    s = signals
    columns = list(order)
    inertial = sign * s.inertial(s.time)

    def curve(values: Array) -> BSpline:
        return cubic_spline(s.time, values[:, columns])

    return LogSignals(
        time=s.time,
        travel=curve(sign * s.travel(s.time)),
        force=curve(s.command(s.time) - inertial),
        command=curve(s.command(s.time)),
        inertial=curve(inertial),
        dry_friction=curve(sign * s.dry_friction(s.time)),
        friction_turnover=curve(sign * s.friction_turnover(s.time)),
        speed=curve(sign * s.speed(s.time)),
        has_force=s.has_force,
    )


def cubic_spline(time: Array, values: Array) -> BSpline:
    """Cubic spline through samples (T, ...) at times (T,)."""
    return make_interp_spline(time, values, k=3)
