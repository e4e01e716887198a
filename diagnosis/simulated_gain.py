"""What an extended model gains in simulation: windows of recordings that were not fitted, from their forces, before and after."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause, with_causes
from diagnosis.effect import LawEffect
from diagnosis.extended_model import extended_model
from diagnosis.fit_stage import FitStage
from diagnosis.held_out_gain import Gain, HeldOutResiduals
from diagnosis.noise_ensemble import NoiseEnsemble
from identification.model_file import Model
from identification.simulation.simulated_recording import SimulatedRecording, simulate_recording, simulated_angles
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MEASURES = {"alpha": "simulated joint angles", "theta": "simulated motor angles"}
"""by stem of the simulated series"""
_MAX_PARTS = 2
"""of a recording, 8 s each, at its beginning and its end: what is simulated to measure a gain (docs/thresholds.md)"""
_SHARE_PARTS = 1
"""of a recording, at its beginning: what is simulated to say how far a cause moves the arm, again for each"""


class SimulatedModel:
    """A model with its description and what it says of how recordings were read."""

    def __init__(
        self,
        stage: FitStage,
        held_out: HeldOutResiduals,
        ensembles: Sequence[NoiseEnsemble],
        noise_floor: bool = True,
    ) -> None:
        """held_out: what it leaves of these recordings; noise_floor: as `simulate_recording` takes it."""
        self._noise_floor = noise_floor
        self._stage, self._h = stage, stage.adjusted(stage.hypothesis)
        self._model: Model = extended_model(stage, {})
        self._recordings = [(e.data, lag) for e, lag in zip(ensembles, held_out.frame_lags, strict=True)]

    @cached_property
    def simulated(self) -> list[SimulatedRecording]:
        """Every recording, read as this model says. Raises Refused where it cannot be simulated."""
        return [
            simulate_recording(
                self._h.corrected(data, lag), self._model, max_parts=_MAX_PARTS, noise_floor=self._noise_floor
            )
            for data, lag in self._recordings
        ]

    def angles_without(self, cause: Cause) -> list[Array]:
        """Joint angles of the first of the same windows, (rows, N), rad, with nothing else changed or fitted anew.

        Raises Refused where an arm without this cause cannot be simulated.
        """
        others = [replace(c, amounts=0 * c.amounts) if c is cause else c for c in self._stage.causes]
        h = self._stage.adjusted(with_causes(self._stage.before_causes, others))
        parameters = self._model.parameters
        if isinstance(cause.effect, LawEffect):
            amounts = {term.name for term in cause.effect.terms}
            parameters = tuple(p.model_copy(update={"value": 0.0}) if p.name in amounts else p for p in parameters)
        model = self._model.model_copy(update={"parameters": parameters})
        return [
            simulated_angles(h.corrected(data, lag), model, full.parameters, max_parts=_SHARE_PARTS)
            for (data, lag), full in zip(self._recordings, self.simulated, strict=True)
        ]


def simulated_gains(before: SimulatedModel, after: SimulatedModel) -> tuple[Gain, ...]:
    """Of alpha and of theta, over all joints and all motors. Raises Refused where a model cannot be simulated."""
    return tuple(_gain(stem, before.simulated, after.simulated) for stem in MEASURES)


def simulated_shares(model: SimulatedModel, causes: Sequence[Cause]) -> tuple[float | None, ...]:
    """By how much each cause moves the simulated angles, RMS of the joint that moves most, rad.

    None where the arm cannot be simulated without it.
    """
    return tuple(_share(model, cause) for cause in causes)


def _share(model: SimulatedModel, cause: Cause) -> float | None:
    try:
        without = model.angles_without(cause)
    except Refused:
        return None
    moved = [w - s.series.matrix("alpha")[: len(w)] for w, s in zip(without, model.simulated, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate(moved) ** 2, axis=0)).max())


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
