"""What noise alone leaves of the residuals: recordings of the same motion with angles drawn anew, through the same chain.

The state as estimated stands for the truth. What smoothing takes away from it, and what the camera's noise adds, is in the
draws; what the base model cannot say is not. That is the floor which a true model would reach.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from diagnosis.held_at_rest import NOTHING_HELD
from diagnosis.hypothesis import Hypothesis
from diagnosis.input_variance import (
    force_steps,
    residuals_of_friction,
    residuals_of_inertia,
    residuals_of_rounding,
)
from diagnosis.linearisation import Linearisation, RecordingLinearisation, corrected_signals
from identification.dataset.dataset import DataSet
from identification.dataset.frames import FrameAngles, spline_through_frames
from identification.dataset.series import Series, numbered_columns
from identification.fitting import segment_starts
from identification.motor_speeds import with_motor_speeds
from identification.residuals import forces_of_other_cables, law_forces_at, mean_friction, residuals_of
from identification.signals import Signals
from identification.whitening import Whitener, fit_whitener
from mechanism.machine import Machine
from state_estimation.state import VisionState, estimate_by_vision

Array = NDArray[np.float64]

DRAWS = 4
"""of every recording's noise (docs/thresholds.md)"""
_WHITE_SHARE = (0.03, 0.10)
"""part of a channel's noise, of the motors' and of the arm's equations, that is laid under it as white (docs/thresholds.md)"""


@dataclass(frozen=True)
class NoiseEnsemble:
    """A recording by vision alone, and the same with its angles drawn anew."""

    data: DataSet
    draws: tuple[DataSet, ...]
    noise_free: DataSet
    """where every frame shows the state itself"""
    _kept: list[tuple[object, list[Signals]]] = field(default_factory=list, repr=False, compare=False)
    """a reading, and the signals by it of `noise_free` and of the draws, whatever their speeds"""

    @cached_property
    def force_steps(self) -> Array:
        """In which steps each motor's force was logged, (M,), N."""
        return force_steps(self.data)

    def signals(self, h: Hypothesis, frame_lag: float) -> list[Signals]:
        """Of `noise_free`, then of the draws, as they read with a hypothesis, the clock put right by a lag, s.

        Those of the last reading are kept: most stages differ by their laws."""
        data, reading = (self.noise_free, *self.draws), (*h.reading, frame_lag)
        if not (self._kept and self._kept[0][0] == reading):
            self._kept[:] = [(reading, corrected_signals(h, data, np.full(len(data), frame_lag)))]
        own = zip(self._kept[0][1], data, strict=True)
        return [s if s.speeds is d.speeds or d.speeds is None else replace(s, speeds=d.speeds) for s, d in own]

    def with_motor_speeds(self, machine: Machine, delay: float) -> "NoiseEnsemble":
        """The same with motor speeds by the friction of `machine`, its forces late by `delay`, s."""
        data = with_motor_speeds(self.data, machine, delay, len(self.draws))
        draws = tuple(replace(draw, speeds=data.speeds) for draw in self.draws)
        return NoiseEnsemble(data, draws, replace(self.noise_free, speeds=data.speeds), self._kept)

    def without(self, stretches: Sequence[tuple[float, float]]) -> "NoiseEnsemble":
        """The same where the rows of stretches, s from the recording's start, are as if they had not been logged."""
        if not stretches:
            return self
        begin = float(self.data.state.time[0])
        gaps = [*self.data.clock.get("log_gaps", ()), *([begin + a, begin + b] for a, b in stretches)]
        data, *draws, noise_free = (
            replace(data, clock={**data.clock, "log_gaps": gaps}) for data in (self.data, *self.draws, self.noise_free)
        )
        return NoiseEnsemble(data, tuple(draws), noise_free)


def noise_ensemble(data: DataSet, frames: FrameAngles, seed: int, draws: int = DRAWS) -> NoiseEnsemble:
    """A recording and its draws; frames: on the log's clock. Cables have no part in the state: they are what is in question."""
    estimate = estimate_by_vision(frames, data.state.time)
    vision_alone = _with_state(data, frames, estimate)
    state = vision_alone.state
    truth = make_interp_spline(state.time, state.matrix("alpha"), k=5)
    inside = (frames.time >= state.time[0]) & (frames.time <= state.time[-1])
    noise_free = frames.alpha.copy()
    noise_free[inside] = np.where(np.isnan(frames.alpha[inside]), np.nan, truth(frames.time[inside]))
    rng = np.random.default_rng(seed)
    noisy_data = []
    for _ in range(draws):
        noisy = replace(frames, alpha=noise_free + frames.sigma * rng.normal(size=noise_free.shape))
        noisy_data.append(_with_state(data, noisy, estimate_by_vision(noisy, state.time, estimate.priors)))
    columns = {**state.columns, **numbered_columns("vision", state.matrix("alpha"))}
    for suffix in ("_d", "_dd"):
        columns |= numbered_columns("vision", state.matrix("alpha", suffix), suffix)
    return NoiseEnsemble(vision_alone, tuple(noisy_data), replace(vision_alone, state=Series(state.time, columns)))


def _with_state(data: DataSet, frames: FrameAngles, estimate: VisionState) -> DataSet:
    """The data set with a state by vision alone."""
    s = data.state
    columns = dict(s.columns)
    for suffix, values in (("", estimate.alpha), ("_d", estimate.alpha_d), ("_dd", estimate.alpha_dd)):
        columns |= numbered_columns("alpha", values, suffix)
    for suffix, values in zip(("", "_d", "_dd"), spline_through_frames(frames.time, frames.alpha, s.time), strict=True):
        columns |= numbered_columns("vision", values, suffix)
    columns |= numbered_columns("bridged", estimate.bridged.astype(float))
    return replace(data, state=Series(s.time, columns))


def noise_residuals(at: Linearisation, ensembles: Sequence[NoiseEnsemble]) -> list[list[Array]]:
    """Residuals where nothing is wrong, (C, S), of each draw of each recording: by noise of the angles and rounding of counts."""
    return [[steady + friction for steady, friction in draws] for draws in _drawn_residuals(at, ensembles)]


def steady_noise_residuals(at: Linearisation, ensembles: Sequence[NoiseEnsemble]) -> list[list[Array]]:
    """The part of `noise_residuals` that is alike in all rows: all but the error of friction, and what it holds at rest."""
    return [[steady for steady, _ in draws] for draws in _drawn_residuals(at, ensembles)]


def _drawn_residuals(at: Linearisation, ensembles: Sequence[NoiseEnsemble]) -> list[list[tuple[Array, Array]]]:
    """Residuals by noise of the angles and by rounding in the motors' inertia, and those by friction, of each draw."""
    out, rng = [], np.random.default_rng(0)
    for r, ensemble in enumerate(ensembles):
        signals = ensemble.signals(at.hypothesis, float(at.frame_lags[r]))
        tension = at.recordings[r].tension
        recording = at.recordings[r]
        laws = recording.laws, recording.values, recording.x0, tension, recording.memory
        first = law_forces_at(signals[0], at.unknowns, at.p, r, tension)
        noise_free, *noisy = (residuals_of(s, forces_of_other_cables(s, first, *laws)) for s in signals)
        s = recording.signals
        steady = [d - noise_free + residuals_of_inertia(s, rng) for d in noisy]
        if ensemble.force_steps.any():
            logged_f, steps = ensemble.data.state.matrix("f"), ensemble.force_steps
            steady = [d + residuals_of_rounding(s, logged_f, steps, rng) for d in steady]
        friction = [residuals_of_friction(s, error) for error in _friction_errors(recording)]
        if (shares := at.hypothesis.held) != NOTHING_HELD:
            friction = [of_motors + recording.held.residuals(shares, s, rng) for of_motors in friction]
        out.append(list(zip(steady, friction, strict=True)))
    return out


def _friction_errors(at: RecordingLinearisation) -> Iterator[Array]:
    """What each draw of the motors' speeds changes of friction, (T, M), N."""
    s, machine = at.signals, Machine(at.signals.arm, at.laws, at.values)
    for error in s.speeds.errors:
        if machine.remembers_path:
            drawn = replace(s, speeds=replace(s.speeds, mean=s.speeds.mean + error))
            yield mean_friction(drawn, machine, at.tension) - mean_friction(s, machine, at.tension)
        else:
            yield at.friction_slopes.by_speed * error.mean(axis=0)


def noise_loss(noise: list[list[Array]], at: Linearisation, whiten: Whitener) -> float:
    """Loss that noise alone makes: the mean over the draws of each recording, summed over recordings."""
    return sum(
        float(np.mean([np.sum(whiten(d, segment_starts(r.signals), r.input_variance) ** 2) for d in draws]))
        for draws, r in zip(noise, at.recordings, strict=True)
    )


def noise_whitener(noise: list[list[Array]], starts: list[NDArray[np.bool_]], motors: int) -> Whitener:
    """Each channel's noise told from what came before, from all draws; starts (S,): first rows of each recording's stretches."""
    rng = np.random.default_rng(0)
    residuals, draw_starts = [], []
    for draws, recording_starts in zip(noise, starts, strict=True):
        for residual in draws:
            share = np.where(np.arange(len(residual)) < motors, *_WHITE_SHARE)[:, None]
            residuals.append(residual + share * residual.std(axis=1, keepdims=True) * rng.normal(size=residual.shape))
            draw_starts.append(recording_starts)
    return fit_whitener(residuals, draw_starts)
