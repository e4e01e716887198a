"""How well the two clocks agree, computed anew from the data set for the figures of the clocks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import log_time
from identification.dataset.dataset import DataSet
from identification.dataset.series import interpolated
from identification.filters import first_order_lag
from mechanism.cable_lengths import lengths
from mechanism.friction import dry

Array = NDArray[np.float64]

EDGE_S = 0.1
"""s left out at both ends, so that a shifted clock stays within the data"""
MAX_SHIFT_S = 0.04
"""s, to both sides: how far the clock is shifted to see how much worse a wrong one fits"""
MIN_GAP_INTERVALS = 1.5
"""a longer time between two frames, in nominal intervals, is a gap"""
_SHIFTS = 41
"""shifts that are tried"""
_LAGS_S = (0.03, 0.1, 3.0)
"""s, by which parts of an elongation may follow the tension: damped cables, and such that creep"""


@dataclass(frozen=True)
class ClockAlignment:
    """Frames with all angles on the log's clock, and the travel of the cables at them."""

    time: Array
    """(F,), s, log clock"""
    predicted: Array
    """cable wound in, (F, M), m, as predicted from the angles and the elongation that the motor force explains"""
    logged: Array
    """cable wound in by the motors, (rd/R) theta, at the same instants, (F, M), m"""
    shifts: Array
    """(K,), s, added to the estimated clock"""
    rms: Array
    """(K, M), m: RMS of logged less predicted at each shift, with all but the clock fitted anew"""

    @property
    def residual(self) -> Array:
        """Logged less predicted travel, (F, M), m."""
        return self.logged - self.predicted


def clock_alignment(data: DataSet) -> ClockAlignment:
    """The alignment by the data set's clock, and by that clock shifted by up to MAX_SHIFT_S to both sides."""
    arm, state = data.arm, data.state
    alpha = data.angles.matrix("alpha")
    time = log_time(data.clock, data.angles.time)
    margin = MAX_SHIFT_S + EDGE_S
    inside = (time > state.time[0] + margin) & (time < state.time[-1] - margin) & ~np.isnan(alpha).any(axis=1)
    time, alpha = time[inside], alpha[inside]
    winding = lengths(arm, np.zeros(arm.N)) - lengths(arm, alpha)
    theta, theta_d = state.matrix("theta"), state.matrix("theta", "_d")
    pull = state.matrix("f") - arm.motor_inertia / arm.drum * state.matrix("theta", "_dd")
    rate = 1 / float(state.time[1] - state.time[0])
    parts = np.stack([pull, dry(theta_d)], axis=1)
    parts = np.concatenate([parts, *(first_order_lag(parts, rate, lag) for lag in _LAGS_S)], axis=1)

    def at(values: Array, shift: float) -> Array:
        return interpolated(time + shift, state.time, values)

    def travel(shift: float) -> tuple[Array, Array]:
        """Logged travel and its prediction, each (F, M), m."""
        logged = arm.drum * at(theta, shift)
        explaining = at(parts.reshape(len(parts), -1), shift).reshape(len(time), -1, arm.M)
        explained = np.empty_like(logged)
        for j in range(arm.M):
            D = np.column_stack([np.ones(len(time)), explaining[:, 0, j] ** 2, explaining[..., j]])
            explained[:, j] = D @ np.linalg.lstsq(D, logged[:, j] - winding[:, j], rcond=None)[0]
        return logged, winding + explained

    shifts = np.linspace(-MAX_SHIFT_S, MAX_SHIFT_S, _SHIFTS)
    rms = []
    for shift in shifts.tolist():
        logged, predicted = travel(shift)
        rms.append(np.sqrt(np.mean((logged - predicted) ** 2, axis=0)))
    logged, predicted = travel(0.0)
    return ClockAlignment(time, predicted, logged, shifts, np.array(rms))


def frame_gaps(known: Array, nominal: float) -> list[tuple[float, float]]:
    """Stretches without angles, (from, to) in s: between the times `known`, longer than MIN_GAP_INTERVALS `nominal` intervals."""
    long = np.flatnonzero(np.diff(known) > MIN_GAP_INTERVALS * nominal)
    return [(float(known[k]), float(known[k + 1])) for k in long]


def stretch_of_most_motion(time: Array, values: Array, length: float) -> tuple[float, float]:
    """The stretch of `length` seconds in which the columns of `values` (T, M) move most."""
    if time[-1] - time[0] <= length:
        return float(time[0]), float(time[-1])
    path = np.r_[0.0, np.cumsum(np.abs(np.diff(values, axis=0)).sum(axis=1))]
    starts = time[time <= time[-1] - length]
    moved = np.interp(starts + length, time, path) - path[: len(starts)]
    start = float(starts[int(np.argmax(moved))])
    return start, start + length
