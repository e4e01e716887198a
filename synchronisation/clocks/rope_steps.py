"""Ropes that moved on their drums while a recording went on: steps of one cable's travel that neither motion nor force makes.

To a clock's fit such a step looks like frames that were lost, or like another arm. It is found before, as what stands out of travel
less winding once force, friction, speed (a clock that is off yet) and slow waves are fitted, and is taken out of what the clock
sees; the check names it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series, numbered
from mechanism.arm import Arm
from synchronisation.clocks.cables import NEWTON
from synchronisation.clocks.signals import LogSignals, log_signals_of

Array = NDArray[np.float64]

TRACE_S = 0.2
"""before and after a step that filtered signals are not of the motion"""
LEAST_M = 1e-3
"""m: smaller ones do a clock no harm"""
MOST = 4
"""looked for in one cable; as many in all are no steps, but something else"""
CLEAR = 5.0
"""times what else is left, RMS, is each step at least: what another arm makes of a motion has no steps as clear"""
WORSE = 1.25
"""times the variance without any one of them, at least"""
WAVES = 4
"""half waves over the recording: what drifts is no step"""
LEAST_FRAMES = 60
"""in both, of which fewer tell no step"""
NEAR_S = 0.02
"""about two frames, in which the motor may have jumped"""
APART_S = 0.5
"""between two steps, and from either end: a step leaves a trace in all signals that are filtered"""


@dataclass(frozen=True)
class RopeStep:
    """From `time` (log, s) on the motor's angle shows `size` (m) more travel than the cable has."""

    cable: int
    time: float
    size: float

    @property
    def trace(self) -> tuple[float, float]:
        """From, to: where filtered signals show what is left of it, s."""
        return self.time - TRACE_S, self.time + TRACE_S

    def words(self) -> str:
        """For a warning."""
        return (
            f"cable {self.cable + 1} seems to have moved on its drum by {1e3 * self.size:+.1f} mm at {self.time:.1f} s: "
            "the clock is fitted as if it had not"
        )


def steady_signals(arm: Arm, log: Series, at: Array, winding: Array) -> tuple[LogSignals, list[RopeStep]]:
    """Signals as if no rope had moved, and the steps that were left out for it.

    From an even log and what angles wind, (F, M), m, in frames at about `at` (F,), s, on the log's clock.
    """
    signals = log_signals_of(arm, log)
    steps = _rope_steps(arm, log, signals, at, winding)
    return (log_signals_of(arm, _without(log, arm, steps)) if steps else signals), steps


def _rope_steps(arm: Arm, log: Series, s: LogSignals, at: Array, winding: Array) -> list[RopeStep]:
    inside = (at > log.time[0]) & (at < log.time[-1])
    at, winding = at[inside], winding[inside]
    if len(at) < LEAST_FRAMES:
        return []
    force, rate = s.force(at) / NEWTON, s.force(at, 1)
    told = [force, force**2, rate, s.command(at, 1), s.rubbing(at), s.turning(at), s.speed(at), s.inertial(at)]
    told += [np.gradient(winding, at, axis=0)]
    slow = np.cos(np.arange(WAVES + 1) * np.pi * ((at - at[0]) / (at[-1] - at[0]))[:, None])
    travel = arm.drum * np.stack([np.interp(at, log.time, theta) for theta in log.matrix("theta").T], axis=-1)
    found = []
    for j in range(arm.M):
        X = np.column_stack([slow, *(column[:, j] for column in told)])
        for k, size in _of_cable(X / np.maximum(np.linalg.norm(X, axis=0), 1e-300), travel[:, j] - winding[:, j], at):
            # where the angle jumps most between the two frames, or about there
            rows = np.flatnonzero((log.time > at[k - 1] - NEAR_S) & (log.time < at[k] + NEAR_S))
            jumps = np.sign(size) * np.diff(log.columns[f"theta{j + 1}"][rows])
            found.append(RopeStep(j, float(log.time[rows[1 + int(np.argmax(jumps))]]), size))
    return found if len(found) < MOST else []


def _without(log: Series, arm: Arm, steps: list[RopeStep]) -> Series:
    """The log as if no rope had moved."""
    theta = log.matrix("theta").copy()
    for one in steps:
        theta[:, one.cable] -= np.where(log.time >= one.time, one.size / arm.drum[one.cable], 0.0)
    return Series(log.time, {**log.columns, **numbered("theta", theta)})


def _of_cable(X: Array, y: Array, at: Array) -> list[tuple[int, float]]:
    """First rows and sizes of steps in y (F,) beside columns X (F, P)."""
    rows = np.arange(len(y))

    def beside(firsts: list[int]) -> Array:
        return np.column_stack([X, *((rows >= k).astype(float) for k in firsts)])

    firsts: list[int] = []
    for _ in range(MOST):
        far = np.all([np.abs(at - at[k]) > APART_S for k in (0, len(at) - 1, *firsts)], axis=0)
        firsts.append(_best(beside(firsts), y, far))
    # one after another those go that the others make needless
    while firsts:
        numbers, left = _left(beside(firsts), y)
        sizes = numbers[X.shape[1] :]
        each = [_left(beside([k for k in firsts if k != out]), y)[1] for out in firsts]
        worst = min(range(len(firsts)), key=lambda i: each[i])
        if each[worst] > WORSE * left and np.min(np.abs(sizes)) > max(LEAST_M, CLEAR * np.sqrt(left)):
            clear = np.all([np.abs(at - at[k]) > TRACE_S for k in firsts], axis=0)
            sizes = _left(beside(firsts)[clear], y[clear])[0][X.shape[1] :]
            return list(zip(firsts, sizes.tolist(), strict=True))
        firsts.pop(worst)
    return []


def _best(X: Array, y: Array, allowed: NDArray[np.bool_]) -> int:
    """The row, of those allowed, from which on a step takes most of what X leaves of y."""
    Q, _ = np.linalg.qr(X)
    left = y - Q @ (Q.T @ y)
    # of all steps at once: sums over the rows from each on
    behind = np.cumsum(Q[::-1], axis=0)[::-1]
    seen = np.arange(len(y), 0, -1) - np.sum(behind**2, axis=1)
    gain = np.cumsum(left[::-1])[::-1] ** 2 / np.maximum(seen, 1.0)
    return max(int(np.argmax(np.where(allowed, gain, 0.0))), 1)


def _left(X: Array, y: Array) -> tuple[Array, float]:
    """Numbers of the columns, and the variance that they leave."""
    numbers = np.asarray(np.linalg.lstsq(X, y, rcond=None)[0], dtype=float)
    return numbers, float(np.mean((y - np.asarray(X @ numbers)) ** 2))
