"""What an extended model gains in simulation: windows of recordings that were not fitted, from their forces, before and after."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_fit import FitStage
from diagnosis.extended_model import adjusted_hypothesis, extended_model
from diagnosis.held_out_gain import Gain, HeldOutResiduals
from diagnosis.hypothesis import Hypothesis
from diagnosis.noise_ensemble import NoiseEnsemble
from identification.model_file import Model
from identification.simulation.simulated_recording import SimulatedRecording, simulate_recording

Array = NDArray[np.float64]

MEASURES = {"alpha": "simulated joint angles", "theta": "simulated motor angles"}
"""by stem of the simulated series"""
_MAX_PARTS = 2
"""of a recording, 8 s each, at its beginning and its end: what is simulated to measure a gain (docs/thresholds.md)"""


class SimulatedModel:
    """A model with its description and what it says of how recordings were read."""

    def __init__(self, stage: FitStage, h: Hypothesis, held_out: HeldOutResiduals) -> None:
        self._h = adjusted_hypothesis(stage, h)
        self._model: Model = extended_model(stage, h, {})
        self._frame_lags = held_out.frame_lags

    def simulated(self, ensembles: Sequence[NoiseEnsemble], noise_floor: bool) -> list[SimulatedRecording]:
        """Every recording, read as this model says; noise_floor as `simulate_recording` takes it."""
        return [
            simulate_recording(
                self._h.corrected(ensemble.data, lag), self._model, max_parts=_MAX_PARTS, noise_floor=noise_floor
            )
            for ensemble, lag in zip(ensembles, self._frame_lags, strict=True)
        ]


def simulated_gains(
    before: SimulatedModel, after: SimulatedModel, ensembles: Sequence[NoiseEnsemble]
) -> tuple[Gain, ...]:
    """Of alpha and of theta, over all joints and all motors. Raises Refused where a model cannot be simulated."""
    new = after.simulated(ensembles, noise_floor=True)
    old = before.simulated(ensembles, noise_floor=False) if before is not after else new
    return tuple(_gain(stem, old, new) for stem in MEASURES)


def _gain(stem: str, old: Sequence[SimulatedRecording], new: Sequence[SimulatedRecording]) -> Gain:
    def level(simulations: Sequence[SimulatedRecording], measure: str) -> float:
        squares = [getattr(c, measure) ** 2 for s in simulations for c in s.channels if c.name.startswith(stem)]
        return float(np.sqrt(np.mean(squares)))

    by_window = np.concatenate(
        [np.stack([_square_by_window(a, stem), _square_by_window(b, stem)]) for a, b in zip(old, new, strict=True)],
        axis=1,
    )
    # by leaving out each window in turn
    count = by_window.shape[1]
    jackknife = np.sqrt((by_window.sum(axis=1, keepdims=True) - by_window) / (count - 1))
    return Gain(
        measure=MEASURES[stem],
        unit="rad",
        before=level(old, "rms"),
        after=level(new, "rms"),
        noise_floor=level(new, "noise_floor"),
        sigma=float(np.sqrt((count - 1) * np.var(jackknife[0] - jackknife[1]))),
    )


def _square_by_window(s: SimulatedRecording, stem: str) -> Array:
    """Mean square of simulated less measured, of every window."""
    error = s.series.matrix(stem) - s.series.matrix(stem, "_measured")
    rows = max(1, round(s.window_s / float(np.mean(np.diff(s.series.time)))))
    count = len(error) // rows
    return np.mean(error[: count * rows].reshape(count, -1) ** 2, axis=1)
