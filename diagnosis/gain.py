"""What an extended model gains where it was not fitted: the same equations on other recordings, before, after, and noise alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.comparison import Comparison, Fitted, compare
from diagnosis.excess import Excess, trusted
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import Linearisation, point, read_all
from diagnosis.noise_ensemble import NoiseEnsemble, noise
from diagnosis.nuisances import errors
from identification.unknowns import unknowns
from identification.whitening import Whitener

Array = NDArray[np.float64]

EQUATIONS = ("motor equations", "arm equations")

_ROUNDS = 6
_SETTLED, _SETTLED_S = 0.02, 2e-5
"""of what a person calls a change, and of a clock: steps that are smaller need not be taken"""
_BLOCKS = 30
"""that the gain's sigma is told from, each left out in turn"""


@dataclass(frozen=True)
class Held:
    """Residuals of recordings that were not fitted, (C, S) each, noise alone there, and their clocks; rows as `trusted`."""

    left: tuple[Array, ...]
    floor: tuple[list[Array], ...]
    late: tuple[float, ...]
    """s, as in Point"""


@dataclass(frozen=True)
class Gain:
    """RMS over the channels of one kind."""

    measure: str
    unit: str
    before: float
    after: float
    noise_floor: float
    sigma: float
    """of before less after, by blocks"""

    def as_json(self) -> dict[str, Any]:
        """The contract's record."""
        return {
            "measure": self.measure,
            "unit": self.unit,
            "before": self.before,
            "after": self.after,
            "noise_floor": self.noise_floor,
            "gain_sigma": self.sigma,
            "held_out": True,
        }


def held(
    end: Comparison, fit: Fitted, h: Hypothesis, read: Sequence[NoiseEnsemble], whiten: Whitener, doubted: bool
) -> Held:
    """Recordings read with a hypothesis and the numbers of its fit; pre-elongation, delay and clock are each recording's own.

    doubted: whether clocks are in doubt for the base model's laws being wrong."""
    left, floor, late_of = [], [], []
    for one in read:
        at = _placed(end.point, fit, h, one)
        now, own = _given(at, end, fit, whiten, doubted)
        for _ in range(_ROUNDS):
            step, base = np.zeros(now.base), own.columns < now.base
            step[own.columns[base]] = own.numbers[base]
            moved = now.clock_moved(own)
            if np.all(np.abs(step) < _SETTLED) and np.all(np.abs(moved) < _SETTLED_S):
                break
            late = at.late + moved
            at = point(h, read_all(h, [one.data], late), at.p + at.unknowns.size * step, late)
            now, own = _given(at, end, fit, whiten, doubted)
        left.extend(now.left(own))
        drawn = noise(at, [one])
        (trust,) = trusted(drawn, [at.places[0].unsure])
        left[-1] = trust * left[-1]
        floor.append([trust * d for d in drawn[0]])
        late_of.append(float(at.late[0]))
    return Held(tuple(left), tuple(floor), tuple(late_of))


def _given(
    at: Linearisation, end: Comparison, fit: Fitted, whiten: Whitener, doubted: bool
) -> tuple[Comparison, Fitted]:
    """With the arm's numbers as they were fitted, and what is the recording's own."""
    arm = len(end.known.names)
    now = compare(at, (), (), errors(at), whiten, doubted=doubted)
    given = np.zeros(len(now.sigma))
    given[now.base : now.base + arm] = fit.numbers[end.base : end.base + arm]
    now = now.shifted(given)
    return now, now.of_recordings()


def gains(before: Held, after: Held, motors: int) -> tuple[Gain, ...]:
    """Of the motors' and of the arm's equations."""
    out = []
    for measure, unit, part in zip(EQUATIONS, ("N", "N m"), (slice(0, motors), slice(motors, None)), strict=True):
        was, now = (np.concatenate([each[part] for each in of.left], axis=1) for of in (before, after))
        drawn = np.concatenate([d[part] for draws in after.floor for d in draws], axis=1)
        rms = [float(np.sqrt(np.mean(each**2))) for each in (was, now, drawn)]
        blocks = np.array_split(np.arange(was.shape[1]), _BLOCKS)
        apart = [
            np.sqrt(np.mean(np.delete(was, b, axis=1) ** 2)) - np.sqrt(np.mean(np.delete(now, b, axis=1) ** 2))
            for b in blocks
        ]
        sigma = float(np.sqrt((_BLOCKS - 1) * np.var(apart)))
        out.append(Gain(measure, unit, rms[0], rms[1], rms[2], sigma))
    return tuple(out)


def excess_of(of: Held, floor: Held) -> Excess:
    """How far recordings that were not fitted stand above noise, channel by channel."""
    every = np.concatenate(of.left, axis=1)
    drawn = np.concatenate([d for draws in floor.floor for d in draws], axis=1)
    return Excess(np.sqrt(np.mean(every**2, axis=1)), np.sqrt(np.mean(drawn**2, axis=1)))


def _placed(of: Linearisation, fit: Fitted, h: Hypothesis, one: NoiseEnsemble) -> Linearisation:
    """The laws' numbers at another recording, which starts with the first one's pre-elongation and delay."""
    fitted = of.p + of.unknowns.size * fit.numbers[: len(of.p)]
    u = unknowns(h.arm, of.unknowns.laws, 1, dict(of.unknowns.held))
    p = u.start()
    for (name, recording), slot in u.slots.items():
        p[slot] = fitted[of.unknowns.slots[name, recording]]
    late = np.zeros(1)
    return point(h, read_all(h, [one.data], late), p, late)
