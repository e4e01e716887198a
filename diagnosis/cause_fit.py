"""Recordings of one arm, to which causes are fitted with the base model's numbers and doubtful clocks."""

from collections.abc import Collection, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause, with_causes
from diagnosis.comparison import Comparison
from diagnosis.descent import MIN_LOSS_GAIN_FAR, Descent, last_fit, with_whole_causes
from diagnosis.fit_stage import FAR, MAX_MISSED, FitStage
from diagnosis.held_at_rest import HeldShares
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import Linearisation, base_unknowns, corrected_signals, linearise
from diagnosis.noise_columns import score_of_noise
from diagnosis.noise_ensemble import (
    NoiseEnsemble,
    noise_loss,
    noise_residuals,
    noise_whitener,
    steady_noise_residuals,
)
from diagnosis.remainder import leaves_plainly_more
from identification.dataset.dataset import DataSet
from identification.estimates import check_motion
from identification.fitting import fit_by_least_squares, segment_starts
from identification.unknowns import DELAY_SIGMA_S
from identification.whitening import Whitener
from mechanism.laws import law_named

Array = NDArray[np.float64]

_PATH_PASSES = 3
"""at most, of telling speeds and fitting what remembers the motors' path, which speeds by the base model's friction bend"""
_MAX_START_X0_M = 5e-3
"""m: pre-elongation beyond the description's that a fit may begin with (docs/thresholds.md)"""
MAX_START_DELAY_S = 3.4 * DELAY_SIGMA_S
"""s: delay of the forces that a fit may begin with (docs/thresholds.md)"""
_MIN_START_STIFFNESS = 0.3
"""of the cables' median stiffness: the least that a fit may begin with (docs/thresholds.md)"""
_MAX_LAST_STEPS, _LEAST_LAST_PROMISE = 3, 0.01
"""of the fit that is reported: steps at most, and of the loss, a tenth of a sigma of a number"""
_PROMISES = 2.0
"""straight steps' worth of what is promised, that a fit is given where it is far from what it must come below"""
_LEAST_NOISE = 0.5
"""of the count of rows: loss that noise hardly makes less than"""
_MAX_NOISE_CHANGE = 1.5
"""times the loss that noise makes by its weights, from which the weights are told anew (docs/thresholds.md)"""
_MAX_HELD_CHANGE = 0.02
"""of the square of what dry friction may hold what rests by: change from which weights are told anew (docs/thresholds.md)"""


class CauseFitter:
    """Recordings of one arm, to which causes are fitted. Raises Refused where a motor stands still."""

    def __init__(self, h: Hypothesis, ensembles: Sequence[NoiseEnsemble]) -> None:
        self._h = h
        first = _base_model_start(h, [ensemble.data for ensemble in ensembles])
        self._ensembles = _with_speeds(ensembles, first)
        self._data = [ensemble.data for ensemble in self._ensembles]
        self._start = _base_model_start(h, self._data, first.p)
        starts = [segment_starts(recording.signals) for recording in self._start.recordings]
        self.whiten = noise_whitener(steady_noise_residuals(self._start, self._ensembles), starts, h.arm.M)
        self._stages: dict[tuple[object, ...], FitStage] = {}

    def base_model(self) -> FitStage:
        """Fitted without a cause: the arm as drawn, within MAX_TOLERANCES."""
        return self.fitted(self._start, ())

    def fitted(self, start: Linearisation, causes: tuple[Cause, ...], to_beat: float = np.inf) -> FitStage:
        """Fitted with these causes, whose shapes are where the fit begins, from a linearisation on; each choice is fitted once.

        to_beat: surplus below which the fit is of use; one that comes nowhere near it ends before its loss is least."""
        key = tuple((c.effect.name, c.where.label, *sorted(c.shape.items())) for c in causes)
        if key not in self._stages:
            target = _Target(to_beat, self._ensembles, self.whiten)
            stage = self._stage(start, causes, target)
            if target.is_given_up:
                return stage
            if stage.is_astray and start is not self._start:
                # along a bent valley a fit may end anywhere: one that begins where no other has been may not
                stage = min(stage, self._stage(self._start, causes, target), key=lambda stage: stage.surplus)
            self._stages[key] = stage
        return self._stages[key]

    @property
    def ensembles(self) -> Sequence[NoiseEnsemble]:
        """Of the recordings, with the motors' speeds by the base model."""
        return self._ensembles

    @property
    def hypothesis(self) -> Hypothesis:
        """To which causes are added, with what is seen of dry friction that holds what rests."""
        return self._h

    def reweighted(self, stage: FitStage) -> "tuple[CauseFitter, FitStage]":
        """The same causes fitted anew with noise as it is with them, and what fits others so."""
        return self._reweighted(stage, self._whitener(stage))

    def with_own_weights(self, stage: FitStage) -> "tuple[CauseFitter, FitStage]":
        """As `reweighted`, where the weights of the fit were of other noise."""
        return self.reweighted(stage) if self._is_ill_weighted(stage) else (self, stage)

    def _is_ill_weighted(self, stage: FitStage) -> bool:
        """Whether noise with a stage's laws is plainly louder or softer than the weights by which it was fitted say.

        Or whether dry friction is seen to hold what rests by more, or by less."""
        level = stage.noise_loss / stage.comparison.row_count
        holds_otherwise = stage.held.furthest_from(self._h.held) > _MAX_HELD_CHANGE
        return holds_otherwise or not 1 / _MAX_NOISE_CHANGE < level < _MAX_NOISE_CHANGE

    def reweighted_by_what_is_left(self, stage: FitStage) -> "tuple[CauseFitter, FitStage]":
        """As `with_own_weights`, where a channel with more than noise counts by what it has.

        Else clocks and friction would give way to what no number mends where a law's form leaves something."""
        fitter, stage = self.with_own_weights(stage)
        at, whiten = stage.comparison.linearisation, fitter._whitener(stage)
        residuals = zip(at.recordings, stage.comparison.residuals_after(stage.fit), strict=True)
        white = [whiten(r, segment_starts(rec.signals), rec.input_variance) for rec, r in residuals]
        level = np.sqrt(np.mean(np.concatenate(white, axis=1) ** 2, axis=1))
        return fitter._reweighted(stage, whiten.rescaled(np.maximum(level, 1.0)))

    def finished(self, stage: FitStage) -> FitStage:
        """With the steps that were too small to be taken while causes were chosen: they may be a sigma of a cause's numbers."""
        score = score_of_noise(stage, self._ensembles, self.whiten)
        current, causes, at = stage.comparison, stage.causes, stage.comparison.linearisation
        current = current.without_noise_in_columns(score)
        data = [replace(d, speeds=r.signals.speeds) for d, r in zip(self._data, at.recordings, strict=True)]
        descent = Descent(self._h, data, self.whiten)
        for _ in range(_MAX_LAST_STEPS):
            promised = with_whole_causes(current, causes).promised
            if promised < _LEAST_LAST_PROMISE:
                break
            candidate, stepped = descent.step(current, 0.0, causes)
            candidate = candidate.without_noise_in_columns(score)
            if with_whole_causes(candidate, stepped).promised > promised:
                break
            current, causes = candidate, stepped
        # numbers of causes stay where they are in the model that is written: the others are the best beside these
        return replace(stage, comparison=current, causes=causes, fit=last_fit(current, current.cause_columns))

    def redrawn(self, stage: FitStage) -> "tuple[CauseFitter, FitStage]":
        """The same causes fitted anew about the arm as it comes out of a fit: from the drawing straight lines may miss it.

        Where more than noise is left what is known to a tolerance may be anywhere: there that is not done. Weights are told anew
        where noise is louder than they say, as of a cable that seemed soft where the fit began: it would stay there."""
        fitter = self
        if not leaves_plainly_more(stage.excess):
            fitter, stage = self._anew(stage, self.whiten, self._h.held)
        is_loud = stage.noise_loss > _MAX_NOISE_CHANGE * stage.comparison.row_count
        return fitter.reweighted(stage) if is_loud else (fitter, stage)

    def with_sticking_motors(self, stage: FitStage) -> "tuple[CauseFitter, FitStage]":
        """The same causes fitted anew where rows in which motors rest count by what is seen of friction that holds them."""
        fitter, stage = self._anew(stage, self.whiten, stage.held_if_motors_stick)
        return fitter.with_own_weights(stage)

    def _whitener(self, stage: FitStage) -> Whitener:
        at = stage.comparison.linearisation
        starts = [segment_starts(recording.signals) for recording in at.recordings]
        return noise_whitener(steady_noise_residuals(at, self._ensembles), starts, self._h.arm.M)

    def _reweighted(self, stage: FitStage, whiten: Whitener) -> "tuple[CauseFitter, FitStage]":
        return self._anew(stage, whiten, stage.held)

    def _anew(self, stage: FitStage, whiten: Whitener, held: HeldShares) -> "tuple[CauseFitter, FitStage]":
        other, h = copy(self), self._h if leaves_plainly_more(stage.excess) else stage.adjusted(self._h)
        other.whiten, other._stages, other._h = whiten, {}, replace(h, held=held)
        return other, other.fitted(stage.comparison.linearisation, stage.causes)

    def _stage(self, start: Linearisation, causes: tuple[Cause, ...], target: "_Target") -> FitStage:
        known, ensembles = self._h.laws, self._ensembles
        passes = _speed_passes([name for name in with_causes(self._h, causes).laws if name not in known])
        if passes:
            comparison, causes, ensembles = self._refined_with_speeds(start, causes, target, passes)
        else:
            descent = Descent(self._h, self._data, self.whiten)
            comparison, causes = descent.refined(start, causes, is_hopeless=target.is_hopeless)
        at = comparison.linearisation
        noise = noise_residuals(at, ensembles)
        loss = noise_loss(noise, at, self.whiten)
        last = last_fit(with_whole_causes(comparison, causes))
        return FitStage(self._h, comparison, causes, tuple(noise), loss, last)

    def _refined_with_speeds(
        self, near: Linearisation, causes: tuple[Cause, ...], target: "_Target", passes: int, before: float = np.inf
    ) -> tuple[Comparison, tuple[Cause, ...], list[NoiseEnsemble]]:
        """As `Descent.refined`, with speeds by the causes' laws: told with the base model's friction they would speak for that.

        passes: of telling speeds and fitting, at most; before: the loss that was left so far."""
        if np.isinf(before) and not near.machine.remembers_path:
            rough, causes = Descent(self._h, self._data, self.whiten).refined(near, causes, rough=True)
            if target.is_hopeless(rough):
                return rough, causes, list(self._ensembles)
            near, before = rough.linearisation, rough.profiled_loss
        ensembles = _with_speeds(self._ensembles, near)
        data = [ensemble.data for ensemble in ensembles]
        descent = Descent(self._h, data, self.whiten)
        comparison, causes = descent.refined(near, causes, is_hopeless=target.is_hopeless)
        loss = comparison.profiled_loss
        if target.is_given_up or passes == 1 or abs(loss / before - 1) < MIN_LOSS_GAIN_FAR:
            return comparison, causes, ensembles
        return self._refined_with_speeds(comparison.linearisation, causes, target, passes - 1, loss)


def fitted_without(
    fitter: CauseFitter, stage: FitStage, left_out: Collection[int], to_beat: float = np.inf
) -> FitStage:
    """The fit without the causes at these places of a stage; to_beat: surplus below which it is of use."""
    rest = tuple(cause for i, cause in enumerate(stage.causes) if i not in left_out)
    return fitter.fitted(stage.comparison.linearisation, rest, to_beat)


@dataclass
class _Target:
    """A surplus that a fit is of use below, and whether it was given up as out of reach."""

    surplus: float
    ensembles: Sequence[NoiseEnsemble]
    whiten: Whitener
    is_given_up: bool = False

    def is_hopeless(self, current: Comparison) -> bool:
        """Whether what is left, less twice what a straight step promises, is far beyond the target and noise."""
        if self.is_given_up or np.isinf(self.surplus):
            return self.is_given_up
        beyond = current.profiled_loss - _PROMISES * current.promised - self.surplus
        if beyond < _LEAST_NOISE * current.row_count:
            return False
        at = current.linearisation
        noise = noise_loss(noise_residuals(at, self.ensembles), at, self.whiten)
        self.is_given_up = beyond > min(noise, FAR * current.row_count) + MAX_MISSED * noise
        return self.is_given_up


def _base_model_start(h: Hypothesis, data: Sequence[DataSet], start: Array | None = None) -> Linearisation:
    """The base model's numbers by least squares, kept from where a cause that is not in it may have driven them."""
    frame_lags = np.zeros(len(data))
    signals = corrected_signals(h, data, frame_lags)
    check_motion(signals)
    u = base_unknowns(h, len(data))
    p = fit_by_least_squares(signals, u, start=start)
    for recording in range(len(data)):
        slot = u.slots["x0", recording]
        p[slot] = np.clip(p[slot], -_MAX_START_X0_M, _MAX_START_X0_M)
        slot = u.slots["delay", recording]
        p[slot] = np.clip(p[slot], -MAX_START_DELAY_S, MAX_START_DELAY_S)
    k = u.slots["k", None]
    p[k] = np.maximum(p[k], _MIN_START_STIFFNESS * np.median(p[k]))
    return linearise(h, signals, p, frame_lags)


def _with_speeds(ensembles: Sequence[NoiseEnsemble], at: Linearisation) -> list[NoiseEnsemble]:
    """Ensembles with motor speeds by the laws and delays of a linearisation."""
    return [e.with_motor_speeds(at.machine, r.delay) for e, r in zip(ensembles, at.recordings, strict=True)]


def _speed_passes(names: Sequence[str]) -> int:
    """How often speeds are told anew with further laws: where these change what turns the motors, or remember their path.

    With the laws of the hypothesis speeds are told from the start."""
    laws = [law_named(name) for name in names]
    if any(law.remembers_path for law in laws):
        return _PATH_PASSES
    return int(any(law.changes_motor_force for law in laws))
