"""Under which conditions a residual arose: tension, speed and its sign, angle, the motor's and the drum's turn, time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.linearisation import RecordingLinearisation

Array = NDArray[np.float64]
Index = NDArray[np.intp]

BINS = 12
"""bins of each condition (docs/thresholds.md)"""
ALONG = ", along the motion"
"""ends the names of conditions under which the residual is taken with the motion's sign"""


@dataclass(frozen=True)
class Condition:
    """Of a channel, at the filter's rows of each recording; what a turn repeats lies between 0 and 1."""

    name: str
    unit: str
    values: tuple[Array, ...]
    """(S,) of each recording"""
    is_cyclic: bool = False
    motion_sign: tuple[Array, ...] | None = None
    """(S,) of each recording, where the residual is taken along the motion: what rubs more or less"""

    def means(self, residual: Sequence[Array]) -> tuple[Array, Array]:
        """Mean and RMS of a residual (S,) of each recording, by bins (K,); NaN where a bin is empty."""
        middles, bins = self.bins()
        signed = residual
        if self.motion_sign is not None:
            signed = [r * sign for r, sign in zip(residual, self.motion_sign, strict=True)]
        flat, r = np.concatenate(bins), np.concatenate(signed)
        count = np.bincount(flat, minlength=len(middles)).astype(float)
        count[count == 0] = np.nan
        square = np.bincount(flat, np.concatenate(residual) ** 2, len(middles))
        return np.bincount(flat, r, len(middles)) / count, np.sqrt(square / count)

    def columns(self) -> list[Array]:
        """One for each bin, (S, K) of each recording: 1 within it, or the motion's sign."""
        middles, bins = self.bins()
        inside = [np.eye(len(middles))[b] for b in bins]
        if self.motion_sign is None:
            return inside
        return [i * sign[:, None] for i, sign in zip(inside, self.motion_sign, strict=True)]

    def bins(self) -> tuple[Array, list[Index]]:
        """Middles (K,), and which bin each row falls in: as many rows in each, or equal parts of a turn and of time."""
        values = np.concatenate(self.values)
        if self.is_cyclic:
            edges = np.linspace(0, 1, BINS + 1)
        elif self.unit == "s":
            edges = np.linspace(0, values.max(), BINS + 1)
        else:
            edges = np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1)))
        inner = edges[1:-1]
        bins = [np.searchsorted(inner, v, side="right") for v in self.values]
        flat = np.concatenate(bins)
        count = np.bincount(flat, minlength=len(inner) + 1)
        middles = np.bincount(flat, values, minlength=len(inner) + 1) / np.maximum(count, 1)
        return np.where(count > 0, middles, (edges[:-1] + edges[1:]) / 2), bins


def conditions(recordings: Sequence[RecordingLinearisation], channel: int) -> tuple[Condition, ...]:
    """Of a channel, counted from 0, the motors' before the joints'."""
    signals = [recording.signals for recording in recordings]
    motors = signals[0].arm.M
    time = tuple(s.kept_time for s in signals)
    cable_tensions = [tensions(recording) for recording in recordings]
    if channel < motors:
        rate = [s.theta_d[:, channel] for s in signals]
        tension = tuple(t[channel] for t in cable_tensions)
        speed_name, tension_name = "speed", "tension"
    else:
        rate = [s.alpha_d[:, channel - motors] for s in signals]
        tension = tuple(t.mean(axis=0) for t in cable_tensions)
        speed_name, tension_name = "joint's speed", "mean tension"
    # of filtered signals the sign of speed is not the filtered sign of speed
    sign = tuple(s.low_pass(np.sign(r)) for s, r in zip(signals, rate, strict=True))
    speed = tuple(s.low_pass(r) for s, r in zip(signals, rate, strict=True))
    out = [Condition(tension_name, "N", tension), Condition(speed_name, "rad/s", speed)]
    if channel < motors:
        R = recordings[0].hypothesis.neck.motors[channel].R
        theta = [s.theta[s.low_pass.kept, channel] for s in signals]
        out += [
            Condition("motor's turn", "turn", tuple(t / (2 * np.pi) % 1 for t in theta), is_cyclic=True),
            Condition("drum's turn", "turn", tuple(t / R / (2 * np.pi) % 1 for t in theta), is_cyclic=True),
        ]
    else:
        alpha = [s.alpha[s.low_pass.kept] for s in signals]
        out += [
            Condition("joint's angle", "rad", tuple(a[:, channel - motors] for a in alpha)),
            Condition("lean of the tip", "rad", tuple(a.sum(axis=1) for a in alpha)),
        ]
    return (
        *out,
        Condition("time", "s", time),
        Condition(tension_name + ALONG, "N", tension, motion_sign=sign),
        Condition("time" + ALONG, "s", time, motion_sign=sign),
    )


def tensions(recording: RecordingLinearisation) -> Array:
    """The model's cable tensions at the filter's rows, (M, S), N, as they follow from the motors: free of vision's noise."""
    return recording.signals.low_pass(recording.motor_forces.pull.T)
