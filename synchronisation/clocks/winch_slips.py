"""Winch slips: cables that moved on their drums while a recording went on, seen as steps of travel that no motion or force makes.

To a clock's fit such a step looks like lost frames or like another arm. It is found as a step that stands out of travel less
winding once force, friction, speed (for the offset may be rough yet) and slow waves are fitted. The clock is fitted to signals
without it (slip_alignment.py); the data stay as they are, and `check` names the fault.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series, interpolated, numbered_columns
from mechanism.arm import Arm
from synchronisation.clocks.cable_equation import FORCE_SCALE_N
from synchronisation.clocks.signals import LogSignals, log_signals_of

Array = NDArray[np.float64]

TRACE_S = 0.2
"""s before and after a slip in which filtered signals are not of the motion (docs/thresholds.md)"""
MIN_SLIP_M = 1e-3
"""m: smaller slips do a clock no harm (docs/thresholds.md)"""
MAX_SLIPS = 4
"""slips that are sought in one cable; as many in all are not slips, but something else (docs/thresholds.md)"""
MIN_SLIP_RATIO = 5.0
"""size of each slip over the RMS of what is left unexplained, at least (docs/thresholds.md)"""
MIN_VARIANCE_RATIO = 1.25
"""variance that is left without any one of the slips over the one with all, at least (docs/thresholds.md)"""
HALF_WAVES = 4
"""half waves over the recording that are fitted along, so that drift is no slip (docs/thresholds.md)"""
MIN_SLIP_FRAMES = 60
"""frames within the log that slips are sought in (docs/thresholds.md)"""
FRAME_MARGIN_S = 0.02
"""s about two frames in which the motor may have jumped (docs/thresholds.md)"""
MIN_SEPARATION_S = 0.5
"""s between two slips and from either end: filtered signals hold a trace of each (docs/thresholds.md)"""


@dataclass(frozen=True)
class WinchSlip:
    """From its time on the motor's angle shows more travel than the cable was wound in."""

    cable: int
    """counted from 0"""
    time: float
    """s, log clock"""
    size: float
    """m"""

    @property
    def trace(self) -> tuple[float, float]:
        """Begin and end of its trace in filtered signals, s, log clock."""
        return self.time - TRACE_S, self.time + TRACE_S

    def warning(self, forces: bool = True) -> str:
        """The slip in words; without forces nobody knows how far a cable stretched."""
        moved = "moved on its drum" if forces else "moved on its drum, or stretched,"
        return (
            f"cable {self.cable + 1} seems to have {moved} by {1e3 * self.size:+.1f} mm at {self.time:.1f} s: "
            "the clock is fitted as if it had not"
        )


def signals_without_slips(
    arm: Arm, log: Series, frame_time: Array, winding: Array
) -> tuple[LogSignals, tuple[WinchSlip, ...]]:
    """The log's signals as if no cable had slipped, and the slips that were left out for that; arguments as of the search."""
    signals = log_signals_of(arm, log)
    slips = find_winch_slips(arm, log, signals, frame_time, winding)
    return (without_slips(arm, log, slips) if slips else signals), slips


def without_slips(arm: Arm, log: Series, slips: Sequence[WinchSlip]) -> LogSignals:
    """The signals of a log of equal steps as if cables had not slipped."""
    theta = log.matrix("theta").copy()
    for slip in slips:
        theta[:, slip.cable] -= np.where(log.time >= slip.time, slip.size / arm.drum[slip.cable], 0.0)
    return log_signals_of(arm, Series(log.time, {**log.columns, **numbered_columns("theta", theta)}))


def find_winch_slips(
    arm: Arm, log: Series, signals: LogSignals, frame_time: Array, winding: Array
) -> tuple[WinchSlip, ...]:
    """The slips of all cables; none where there are more than slips could be.

    log: of equal steps, with its signals; winding: (F, M), m, of frames at about frame_time (F,), s, log clock."""
    inside = (frame_time > log.time[0]) & (frame_time < log.time[-1])
    at, winding = frame_time[inside], winding[inside]
    if len(at) < MIN_SLIP_FRAMES:
        return ()
    explaining = _explaining_signals(signals, at, winding)
    waves = np.cos(np.arange(HALF_WAVES + 1) * np.pi * ((at - at[0]) / (at[-1] - at[0]))[:, None])
    travel = arm.drum * interpolated(at, log.time, log.matrix("theta"))
    slips = []
    for j in range(arm.M):
        X = np.column_stack([waves, *(signal[:, j] for signal in explaining)])
        X = X / np.maximum(np.linalg.norm(X, axis=0), 1e-300)
        for k, size in _steps(X, travel[:, j] - winding[:, j], at):
            span = (at[k - 1] - FRAME_MARGIN_S, at[k] + FRAME_MARGIN_S)
            slips.append(WinchSlip(j, _time_of_jump(log, j, span, size), size))
    return tuple(slips) if len(slips) < MAX_SLIPS else ()


def _explaining_signals(s: LogSignals, at: Array, winding: Array) -> list[Array]:
    """What travel less winding may consist of at log times (F,), s, beside slips and drift; (F, M) each."""
    force, rate = s.force(at) / FORCE_SCALE_N, s.force(at, 1)
    frictions = [friction(at) for friction in (s.dry_friction, *s.friction_forms)]
    motors = [s.command(at, 1), *frictions, s.speed(at), s.inertial(at)]
    return [force, force**2, rate, *motors, np.gradient(winding, at, axis=0)]


def _time_of_jump(log: Series, cable: int, span: tuple[float, float], size: float) -> float:
    """The time within a span, s, at which the motor's angle jumps most in the direction of a slip."""
    rows = np.flatnonzero((log.time > span[0]) & (log.time < span[1]))
    jumps = np.sign(size) * np.diff(log.columns[f"theta{cable + 1}"][rows])
    return float(log.time[rows[1 + int(np.argmax(jumps))]])


def _steps(X: Array, y: Array, at: Array) -> list[tuple[int, float]]:
    """First frame and size of each clear step in y (F,) at times (F,), s, beside columns X (F, P)."""
    frames = np.arange(len(y))

    def with_steps(firsts: list[int]) -> Array:
        return np.column_stack([X, *((frames >= k).astype(float) for k in firsts)])

    firsts: list[int] = []
    for _ in range(MAX_SLIPS):
        allowed = np.all([np.abs(at - at[k]) > MIN_SEPARATION_S for k in (0, len(at) - 1, *firsts)], axis=0)
        firsts.append(_best_step(with_steps(firsts), y, allowed))
    # then those are dropped one after another that the others make needless
    while firsts:
        coefficients, variance = _least_squares(with_steps(firsts), y)
        sizes = coefficients[X.shape[1] :]
        without = [_least_squares(with_steps([k for k in firsts if k != out]), y)[1] for out in firsts]
        least = min(range(len(firsts)), key=lambda i: without[i])
        clear = np.min(np.abs(sizes)) > max(MIN_SLIP_M, MIN_SLIP_RATIO * np.sqrt(variance))
        if clear and without[least] > MIN_VARIANCE_RATIO * variance:
            undisturbed = np.all([np.abs(at - at[k]) > TRACE_S for k in firsts], axis=0)
            sizes = _least_squares(with_steps(firsts)[undisturbed], y[undisturbed])[0][X.shape[1] :]
            return list(zip(firsts, sizes.tolist(), strict=True))
        firsts.pop(least)
    return []


def _best_step(X: Array, y: Array, allowed: NDArray[np.bool_]) -> int:
    """The frame, of those allowed, from which on a step explains most of what columns X (F, P) leave of y (F,)."""
    Q, _ = np.linalg.qr(X)
    residual = y - Q @ (Q.T @ y)
    # all steps at once: sums over the frames from each on
    explained = np.cumsum(Q[::-1], axis=0)[::-1]
    energy = np.arange(len(y), 0, -1) - np.sum(explained**2, axis=1)
    gain = np.cumsum(residual[::-1])[::-1] ** 2 / np.maximum(energy, 1.0)
    return max(int(np.argmax(np.where(allowed, gain, 0.0))), 1)


def _least_squares(X: Array, y: Array) -> tuple[Array, float]:
    """Coefficients of the columns, and the variance that they leave."""
    coefficients = np.asarray(np.linalg.lstsq(X, y, rcond=None)[0], dtype=float)
    return coefficients, float(np.mean((y - np.asarray(X @ coefficients)) ** 2))
