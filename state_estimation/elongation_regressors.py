"""Regressors of a cable's elongation from its motor's force and speed: x = X beta + e.

The columns of X, in their order:
1, t, t^2, t^3: a constant, the tension t, and a cable that stiffens;
t', f': damping, or a lag that is wrong; and a command f that comes late;
t behind by each of CREEP_S: creep;
dry friction, its transition, bristles that bend before it slides, viscous friction: an error of the friction that was taken off.

The tension is t = n - friction with n = f - Ia (R/rd) theta''. Forces and friction may be behind by the lag of a spring
beside a damper.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.filters import first_order_lag, low_pass
from mechanism.arm import Arm
from mechanism.bristles import BEND_WIDTHS_RAD, mean_bend
from mechanism.friction import CM
from state_estimation.motors import Motors

Array = NDArray[np.float64]

CREEP_S = (1.5, 6.0)
"""s: time constants of creep (docs/thresholds.md)"""
CUTOFF_HZ = 20.0
"""Hz: low-pass of all signals; above the motion, below the steps that friction's reversals make in each of them
(docs/thresholds.md)"""
FRICTION_TERMS = 3 + len(BEND_WIDTHS_RAD)
"""dry friction, its transition, what it is less than dry friction while bristles bend, viscous friction"""
TENSION, TENSION_RATE = 1, 4
"""columns of X that hold t and its rate"""
CREEP, FRICTION, VISCOUS = slice(6, 6 + len(CREEP_S)), slice(-FRICTION_TERMS, None), -1
"""columns of X that hold creep and friction, and the one that holds the speed theta'"""
MIN_TURN = 1e-4
"""change of CM theta' over a step below which the value at the step's middle stands for the mean"""


@dataclass(frozen=True)
class ForceSignals:
    """Forces and friction of each motor at even times, each (T, M): means over the log's steps, low-passed, at the steps' ends."""

    time: Array
    """(T,), s"""
    force: Array
    """n = f - Ia (R/rd) theta'', N or another unit"""
    command: Array
    """f, in the unit of `force`"""
    friction: tuple[Array, ...]
    """for 1 N: dry friction, its transition, bends of bristles less dry friction; and the speed theta', rad/s"""

    @property
    def rate(self) -> float:
        """Hz"""
        return 1 / float(np.mean(np.diff(self.time)))

    def in_unit(self, newton: float) -> "ForceSignals":
        """These signals with forces counted in `newton` N."""
        return replace(self, force=self.force / newton, command=self.command / newton)

    def lagged(self, lag: Array) -> "ForceSignals":
        """These signals behind by the lag of each cable, (M,), s."""
        force, command, *friction = (
            first_order_lag(s, self.rate, lag) for s in (self.force, self.command, *self.friction)
        )
        return replace(self, force=force, command=command, friction=tuple(friction))

    def tension(self, friction: Array) -> Array:
        """t (T, M) where friction's terms have the sizes (M, FRICTION_TERMS)."""
        return self.force - sum(term * size for term, size in zip(self.friction, friction.T, strict=True))

    def regressors(self, tension: Array) -> Iterator[Array]:
        """Columns of X at the even times, each (T, M), one at a time: all of them would be most of memory."""
        yield np.ones_like(tension)
        yield tension
        squared = tension**2
        yield squared
        yield squared * tension
        yield np.gradient(tension, 1 / self.rate, axis=0)
        yield np.gradient(self.command, 1 / self.rate, axis=0)
        for tau in CREEP_S:
            yield first_order_lag(tension, self.rate, tau)
        yield from self.friction


def force_signals(arm: Arm, motors: Motors) -> ForceSignals:
    """From motor speeds and forces at the log's even times.

    A command is held over its step, so all else is its mean over the step: friction turns over within less than one.
    """
    rate = 1 / float(np.mean(np.diff(motors.time)))
    if motors.within_rows is None:
        at_rows, (dry, transition, speed) = motors.theta_d, friction_over_steps(motors.theta_d)
    else:
        before, after = motors.within_rows.mean
        at_rows, (dry, transition, speed) = (before + after) / 2, _friction_over_halves(after[:-1], before[1:])
    bends = (mean_bend(motors.theta, width) - dry for width in BEND_WIDTHS_RAD)
    force = motors.f[:-1] - arm.motor_inertia / arm.drum * np.diff(at_rows, axis=0) * rate
    means = (force, motors.f[:-1], dry, transition, *bends, speed)
    # each column in one piece, as regressors are made of it again and again
    force, command, *friction = (np.asfortranarray(at_step_ends(low_pass(mean, rate, CUTOFF_HZ))) for mean in means)
    return ForceSignals(time=motors.time, force=force, command=command, friction=tuple(friction))


def friction_over_steps(theta_d: Array) -> tuple[Array, Array, Array]:
    """Means over each step of dry friction of 1 N, its transition, and the speed, (T - 1, M), of speeds (T, M) straight between."""
    turn = CM * theta_d
    log_root = np.log1p(turn**2) / 2
    change = np.diff(turn, axis=0)
    small = np.abs(change) < MIN_TURN
    divisor = np.where(small, 1.0, change)
    middle = (turn[1:] + turn[:-1]) / 2
    # integrals of atan(u) and of u / (1 + u^2)
    dry = np.where(small, np.arctan(middle), np.diff(turn * np.arctan(turn) - log_root, axis=0) / divisor)
    transition = np.where(small, middle / (1 + middle**2), np.diff(log_root, axis=0) / divisor)
    return 2 / np.pi * dry, transition, middle / CM


def _friction_over_halves(first: Array, second: Array) -> tuple[Array, Array, Array]:
    """The same of the mean speeds in both halves of each step, (T - 1, M) each."""
    turns = CM * np.stack([first, second])
    return 2 / np.pi * np.arctan(turns).mean(axis=0), (turns / (1 + turns**2)).mean(axis=0), turns.mean(axis=0) / CM


def at_step_ends(means: Array) -> Array:
    """Values (T, M) at the ends of steps of a smooth signal whose means over the steps are (T - 1, M): exact for cubics."""
    padded = np.pad(means, ((2, 2), (0, 0)), mode="edge")
    return (7 * (padded[1:-2] + padded[2:-1]) - padded[:-3] - padded[3:]) / 12
