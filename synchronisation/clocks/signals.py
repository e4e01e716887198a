"""The log's signals as the clock's equations need them: through one low-pass filter, as splines over the log's time.

Row n of a log holds the force from that row on, until the next. So the motor's equation is taken in integral form: force, inertia
and friction are means over the log's steps, and the means of the steps give the values at the rows between them. Friction turns
over within less than a step; its values at the rows alone would miss that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline

from identification.dataset.series import Series
from identification.filters import first_order_lag, low_pass
from identification.motor_rest import rests_near
from mechanism.arm import Arm
from mechanism.bristles import BEND_WIDTHS_RAD, mean_bend
from state_estimation.elongation_regressors import at_step_ends, friction_over_steps

Array = NDArray[np.float64]

SIGNAL_CUTOFF_HZ = 20.0
"""Hz: above what cables and motors do, below where encoder counts swamp accelerations"""
FRICTION_SPEED_CUTOFF_HZ = 80.0
"""Hz: of the speed that dry friction is computed from; a lower one blunts its reversals, which looks like forces that come late,
and a higher one lets counts of the encoder in (docs/thresholds.md)"""
TURNOVER_RATIO = 3.0
"""ratio of the speeds over which friction turns over; sums of three such arc tangents come within 0.2 N of any curve that turns
over once, of 14 N in all (docs/thresholds.md)"""
FRICTION_FORMS = 3 + len(BEND_WIDTHS_RAD)
"""forms of friction beside the arc tangent"""
FRICTION_RATE_HZ = 500.0
"""Hz: rate at which friction is computed within the periods of slower logs"""
GRID_HZ = 100.0
"""Hz: rate at which the filtered signals are kept"""
LAG_STEPS = 8
"""steps, of those at which signals are kept, in which a lagging command is taken for a straight line"""


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
    friction_forms: tuple[BSpline, ...]
    """what makes of `dry_friction` any friction that turns over with the speed: its slope by log cm, and what friction has beyond
    it that turns over at a third and at three times of its speed, or after bristles have bent, ratios"""
    speed: BSpline
    """theta', rad/s"""
    has_force: bool
    """whether the log holds forces; without them f is taken as zero"""
    rest: BSpline
    """1 where the motor is at rest, or so soon before or after that the filter mixes what friction does, else 0"""

    @cached_property
    def tension_parts(self) -> Array:
        """What a tension consists of, (G, parts, M): force, dry friction, its forms, speed, the command's rate, inertial force."""
        curves = (self.force, self.dry_friction, *self.friction_forms, self.speed)
        values = [*(curve(self.time) for curve in curves), self.command(self.time, 1), self.inertial(self.time)]
        return np.stack(values, axis=1)

    def at_rest(self, at: Array) -> NDArray[np.bool_]:
        """Whether each motor is at rest around log times (F,), s: (F, M)."""
        return np.asarray(self.rest(at) > 0.5)

    def late(self, by: float, smeared: bool) -> "LogSignals":
        """The signals if commands acted later by `by`, s, than the log says: all at once, or smeared by a first-order lag."""
        if smeared:
            finely = np.linspace(self.time[0], self.time[-1], LAG_STEPS * (len(self.time) - 1) + 1)
            rate = (len(finely) - 1) / float(finely[-1] - finely[0])
            acting = first_order_lag(self.command(finely), rate, by)[::LAG_STEPS]
        else:
            acting = self.command(np.clip(self.time - by, self.time[0], self.time[-1]))
        command = cubic_spline(self.time, acting)
        return replace(self, command=command, force=cubic_spline(self.time, acting - self.inertial(self.time)))


def log_signals_of(arm: Arm, log: Series) -> LogSignals:
    """The signals of a log of equal steps; without columns f the force is that of the motors' inertia alone."""
    rate = (len(log) - 1) / float(log.time[-1] - log.time[0])
    theta, f = log.matrix("theta"), log.matrix("f")
    has_force = f.shape[1] == arm.M
    f = f if has_force else np.zeros_like(theta)
    smooth = low_pass(theta, rate, SIGNAL_CUTOFF_HZ)
    fast = cubic_spline(log.time, low_pass(theta, rate, FRICTION_SPEED_CUTOFF_HZ))
    parts = max(1, round(FRICTION_RATE_HZ / rate))
    within = np.linspace(log.time[0], log.time[-1], parts * (len(log) - 1) + 1)
    path, fast_d = fast(within), fast(within, 1)
    dry, transition, _ = (_joined(means, parts) for means in friction_over_steps(fast_d))
    sharper, blunter = (
        _joined(friction_over_steps(ratio * fast_d)[0], parts) for ratio in (TURNOVER_RATIO, 1 / TURNOVER_RATIO)
    )
    bends = (_joined(mean_bend(path, width), parts) for width in BEND_WIDTHS_RAD)
    forms = (2 / np.pi * transition, sharper - dry, blunter - dry, *(bend - dry for bend in bends))
    theta_dd = np.diff(fast_d[::parts], axis=0) * rate
    every = max(1, round(rate / GRID_HZ))
    time = log.time[::every]

    def curve(values: Array) -> BSpline:
        return cubic_spline(time, values[::every])

    def of_means(means: Array) -> Array:
        return low_pass(at_step_ends(means), rate, SIGNAL_CUTOFF_HZ)

    command, inertial = of_means(f[:-1]), arm.motor_inertia / arm.drum * of_means(theta_dd)
    return LogSignals(
        time=time,
        travel=curve(arm.drum * smooth),
        force=curve(command - inertial),
        command=curve(command),
        inertial=curve(inertial),
        dry_friction=curve(of_means(dry)),
        friction_forms=tuple(curve(of_means(form)) for form in forms),
        speed=curve(cubic_spline(log.time, smooth)(log.time, 1)),
        has_force=has_force,
        rest=curve(rests_near(theta, rate).astype(float)),
    )


def _joined(means: Array, parts: int) -> Array:
    """Means over whole steps, (T, M), from the means over equal parts of them, (T * parts, M)."""
    return means.reshape(-1, parts, means.shape[1]).mean(axis=1)


def relabelled(signals: LogSignals, order: Sequence[int], sign: int) -> LogSignals:
    """The signals if motor j's column of the log were column order[j], and all motors counted theta by `sign` (1 or -1)."""
    s = signals
    columns = list(order)

    def curve(spline: BSpline, factor: int) -> BSpline:
        # a spline is linear in its coefficients
        return BSpline(spline.t, factor * np.asarray(spline.c)[:, columns], spline.k)

    return LogSignals(
        time=s.time,
        travel=curve(s.travel, sign),
        force=curve(BSpline(s.command.t, s.command.c - sign * s.inertial.c, s.command.k), 1),
        command=curve(s.command, 1),
        inertial=curve(s.inertial, sign),
        dry_friction=curve(s.dry_friction, sign),
        friction_forms=tuple(curve(form, sign) for form in s.friction_forms),
        speed=curve(s.speed, sign),
        has_force=s.has_force,
        rest=curve(s.rest, 1),
    )


def cubic_spline(time: Array, values: Array) -> BSpline:
    """Cubic spline through samples (T, ...) at times (T,)."""
    return make_interp_spline(time, values, k=3)
