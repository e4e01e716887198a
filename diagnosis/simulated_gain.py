"""What an extended model gains in simulation: windows of recordings that were not fitted, from their forces, before and after."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_fit import FitStage
from diagnosis.extended_model import description, model
from diagnosis.gain import Gain, Held
from diagnosis.hypothesis import Hypothesis
from diagnosis.noise_ensemble import NoiseEnsemble
from identification.model_file import Model
from identification.simulation.simulated import Simulated, simulate_recording

Array = NDArray[np.float64]

STEMS = {"alpha": "simulated joint angles", "theta": "simulated motor angles"}


def simulated_gains(before: "Side", after: "Side", read: Sequence[NoiseEnsemble]) -> tuple[Gain, ...]:
    """Of alpha and of theta, over all joints and all motors. Raises Refused where a model cannot be simulated."""
    was, now = before.simulated(read), after.simulated(read)
    return tuple(_gain(stem, was, now) for stem in STEMS)


class Side:
    """A model with its description and what it says of how recordings were read."""

    def __init__(self, turn: FitStage, h: Hypothesis, held: Held) -> None:
        self._h = Hypothesis(description(turn, h), h.laws, h.values, h.misread, h.late, h.stale)
        self._model: Model = model(turn, h, {})
        self._late = held.late

    def simulated(self, read: Sequence[NoiseEnsemble]) -> list[Simulated]:
        """Every recording, read by this side's lights."""
        return [
            simulate_recording(self._h.read(one.data, late), self._model)
            for one, late in zip(read, self._late, strict=True)
        ]


def _gain(stem: str, was: Sequence[Simulated], now: Sequence[Simulated]) -> Gain:
    def level(of: Sequence[Simulated], which: str) -> float:
        return float(
            np.sqrt(np.mean([getattr(c, which) ** 2 for s in of for c in s.channels if c.name.startswith(stem)]))
        )

    before, after = level(was, "rms"), level(now, "rms")
    each = np.concatenate(
        [np.stack([_by_window(a, stem), _by_window(b, stem)]) for a, b in zip(was, now, strict=True)], axis=1
    )
    # by leaving out each window in turn
    count = each.shape[1]
    left = np.sqrt((each.sum(axis=1, keepdims=True) - each) / (count - 1))
    sigma = float(np.sqrt((count - 1) * np.var(left[0] - left[1])))
    return Gain(STEMS[stem], "rad", before, after, level(now, "noise_floor"), sigma)


def _by_window(s: Simulated, stem: str) -> Array:
    """Mean square of simulated less measured, of every window."""
    error = s.series.matrix(stem) - s.series.matrix(stem, "_measured")
    rows = max(1, round(s.window_s / float(np.mean(np.diff(s.series.time)))))
    count = len(error) // rows
    return np.mean(error[: count * rows].reshape(count, -1) ** 2, axis=1)
