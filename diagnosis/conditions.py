"""Under which conditions a residual arose: tension, speed and its sign, angle, the motor's and the drum's turn, time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.linearisation import RecordingLinearisation
from identification.residuals import forces

Array = NDArray[np.float64]
Index = NDArray[np.intp]

BINS = 12
ALONG = ", along the motion"
"""of conditions under which the residual is taken with the motion's sign"""


@dataclass(frozen=True)
class Condition:
    """Of a channel, at the filter's rows of each recording; what a turn repeats lies between 0 and 1."""

    name: str
    unit: str
    values: tuple[Array, ...]
    turns: bool = False
    along: tuple[Array, ...] | None = None
    """sign of the motion, where the residual is taken along it: what rubs more or less; (S,) each"""

    def means(self, residual: Sequence[Array]) -> tuple[Array, Array]:
        """Mean and RMS of a residual (S,) of each recording, by bins; NaN where a bin is empty."""
        middles, which = self.bins()
        signed = residual if self.along is None else [r * way for r, way in zip(residual, self.along, strict=True)]
        flat, r = np.concatenate(which), np.concatenate(signed)
        count = np.bincount(flat, minlength=len(middles)).astype(float)
        count[count == 0] = np.nan
        square = np.bincount(flat, np.concatenate(residual) ** 2, len(middles))
        return np.bincount(flat, r, len(middles)) / count, np.sqrt(square / count)

    def columns(self) -> list[Array]:
        """One for each bin, (S, K) of each recording: 1 within it, or the motion's sign."""
        middles, which = self.bins()
        inside = [np.eye(len(middles))[w] for w in which]
        return inside if self.along is None else [i * way[:, None] for i, way in zip(inside, self.along, strict=True)]

    def bins(self) -> tuple[Array, list[Index]]:
        """Middles (K,), and which bin each row falls in: as many rows in each, or equal parts of a turn and of time."""
        every = np.concatenate(self.values)
        if self.turns:
            edges = np.linspace(0, 1, BINS + 1)
        elif self.unit == "s":
            edges = np.linspace(0, every.max(), BINS + 1)
        else:
            edges = np.unique(np.quantile(every, np.linspace(0, 1, BINS + 1)))
        inner = edges[1:-1]
        which = [np.searchsorted(inner, v, side="right") for v in self.values]
        flat = np.concatenate(which)
        count = np.bincount(flat, minlength=len(inner) + 1)
        middles = np.bincount(flat, every, minlength=len(inner) + 1) / np.maximum(count, 1)
        return np.where(count > 0, middles, (edges[:-1] + edges[1:]) / 2), which


def conditions(places: Sequence[RecordingLinearisation], channel: int) -> tuple[Condition, ...]:
    """Of a channel, counted from 0, the motors' before the joints'."""
    signals = [place.signals for place in places]
    motors = signals[0].arm.M
    time = tuple(s.time[s.low_pass.kept] - s.time[0] for s in signals)
    pulls = [tensions(place) for place in places]
    if channel < motors:
        rate = [s.theta_d[:, channel] for s in signals]
        tension = tuple(p[channel] for p in pulls)
        name, on = "speed", "tension"
    else:
        rate = [s.alpha_d[:, channel - motors] for s in signals]
        tension = tuple(p.mean(axis=0) for p in pulls)
        name, on = "joint's speed", "mean tension"
    # of filtered signals the sign of speed is not the filtered sign of speed
    way = tuple(s.low_pass(np.sign(r)) for s, r in zip(signals, rate, strict=True))
    speed = tuple(s.low_pass(r) for s, r in zip(signals, rate, strict=True))
    out = [Condition(on, "N", tension), Condition(name, "rad/s", speed)]
    if channel < motors:
        R = places[0].hypothesis.neck.motors[channel].R
        theta = [s.theta[s.low_pass.kept, channel] for s in signals]
        out += [
            Condition("motor's turn", "turn", tuple(t / (2 * np.pi) % 1 for t in theta), turns=True),
            Condition("drum's turn", "turn", tuple(t / R / (2 * np.pi) % 1 for t in theta), turns=True),
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
        Condition(on + ALONG, "N", tension, along=way),
        Condition("time" + ALONG, "s", time, along=way),
    )


def tensions(place: RecordingLinearisation) -> Array:
    """Of the cables as the model has them at the filter's rows, (M, S), N: from what the motors tell, free of vision's noise."""
    pull = forces(place.told, place.laws, place.values, place.x0, place.delay).pull
    return place.signals.low_pass(pull.T)
