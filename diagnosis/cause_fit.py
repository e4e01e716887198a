"""Causes fitted together with the base model's numbers and doubtful clocks, and what they leave."""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause, with_causes
from diagnosis.compare import compare
from diagnosis.comparison import ColumnFit, Comparison, Index
from diagnosis.held_joints import held_share, square_at_rows
from diagnosis.hypothesis import Hypothesis
from diagnosis.judged_rows import judged
from diagnosis.linearisation import Linearisation, base_unknowns, corrected_signals, linearise, with_laws_of
from diagnosis.noise_ensemble import (
    NoiseEnsemble,
    noise_loss,
    noise_residuals,
    noise_whitener,
    steady_noise_residuals,
)
from diagnosis.noise_excess import NoiseExcess, noise_excess
from diagnosis.nuisances import nuisances_at
from identification.dataset.dataset import DataSet
from identification.estimates import check_motion
from identification.fitting import fit_by_least_squares, segment_starts
from identification.unknowns import DELAY_SIGMA_S
from identification.whitening import Whitener
from mechanism.laws import law_named
from mechanism.laws.law import Law

Array = NDArray[np.float64]

_MAX_ROUNDS, _MAX_STEPS, _FIRST_STEPS = 3, 24, 6
"""of steps, steps of a round, and steps of one that only brings the laws near enough to tell speeds by"""
_PATH_PASSES = 3
"""at most, of telling speeds and fitting what remembers the motors' path, which speeds by the base model's friction bend"""
_MIN_CLOCK_STEP_S = 1e-4
"""s: up to which frames need not be read anew, for what they show changes in proportion"""
_MAX_START_X0_M = 5e-3
"""m: pre-elongation beyond the description's that a fit may begin with (docs/thresholds.md)"""
MAX_START_DELAY_S = 3.4 * DELAY_SIGMA_S
"""s: delay of the forces that a fit may begin with (docs/thresholds.md)"""
_MIN_START_STIFFNESS = 0.3
"""of the cables' median stiffness: the least that a fit may begin with (docs/thresholds.md)"""
_MIN_PROMISE, _MIN_PROMISE_SHARE = 2.0, 1e-3
"""of the loss, and of what of it is beyond noise: a step that promises less is not taken, for the fit ends with a straight one"""
_SHORT_GAIN = 0.5
"""of what a straight step promised: where it took less, shapes may have gone ahead of all else"""
_SETTLING_STEPS = 4
"""for given shapes: most numbers are all but linear"""
_MAX_LAST_STEPS, _LEAST_LAST_PROMISE = 3, 0.01
"""of the fit that is reported: steps at most, and of the loss, a tenth of a sigma of a number"""
_MAX_LAST_CHANGE = 0.5
"""of a number that acts by its ratio: change that a straight step tells of"""
MAX_MISSED = 0.1
"""of the loss that noise makes: what a straight step may promise at the end of a fit (docs/thresholds.md)"""
_MIN_LOSS_GAIN, _MIN_LOSS_GAIN_FAR = 1e-3, 1e-2
"""of the loss: a step that took less away was the last; and where far more than noise is left"""
_NEARER_SHARE = 0.3
"""of what a straight step promised: what is promised after a good one"""
_LOST = 1.5
"""times the least loss of a round: one that ends there has lost its way"""
_FAR = 4.0
"""losses of noise from which a fit is far"""
MAX_TOLERANCES = 4.0
"""standard deviations up to which a number may be off its drawing (docs/thresholds.md)"""
IMPOSSIBLE_SIGMAS = 3.0
"""standard deviations below its least value from which an amount is impossible (docs/thresholds.md)"""
UNTOLD_SIGMAS = 2.0
"""standard deviations within which all amounts of a cause are nothing (docs/thresholds.md)"""
MAX_OPPOSED_SHARE = 0.2
"""of what a cause does in the equations: what amounts below their least value may do (docs/thresholds.md)"""
_MAX_NOISE_CHANGE = 1.5
"""times the loss that noise makes by its weights, from which the weights are told anew (docs/thresholds.md)"""
_MAX_HELD_CHANGE = 0.02
"""of the square of what dry friction may hold joints at rest by: change from which weights are told anew (docs/thresholds.md)"""
_FIRST_DAMPING, _MAX_DAMPING = 1e-3, 10.0
_DAMPING_DECREASE, _DAMPING_INCREASE = 3.0, 8.0


@dataclass(frozen=True)
class FitStage:
    """Recordings with the causes named so far."""

    comparison: Comparison
    """at the end of the fit"""
    causes: tuple[Cause, ...]
    """with numbers"""
    noise: tuple[list[Array], ...]
    """residuals of noise alone, (C, S), by recording and draw"""
    noise_loss: float
    """loss that noise alone makes"""
    fit: ColumnFit

    @cached_property
    def sigma(self) -> Array:
        """Of all numbers of the fit, in their sizes, (K,); infinite where nothing tells them."""
        variance = np.diag(self.comparison.covariance(self.fit))
        return np.sqrt(np.where(variance > 0, variance, np.inf))

    @cached_property
    def sigma_of_causes(self) -> tuple[Array, ...]:
        """Of each cause's amounts, then its shape terms, in their units; infinite at the end of a shape's range."""
        c = self.comparison
        arm, sigma = c.linearisation.hypothesis.arm, self.sigma[c.base_count + c.nuisance_count :]
        out = []
        for cause in self.causes:
            sizes = cause.sizes(arm)
            of_amounts, of_shape = np.split(sizes * sigma[: len(sizes)], [len(cause.amounts)])
            out.append(np.append(of_amounts, np.where(cause.at_limit(arm), np.inf, of_shape)))
            sigma = sigma[len(sizes) :]
        return tuple(out)

    @property
    def possible(self) -> bool:
        """Whether no cause does surely less than nothing, or more than any such thing does."""
        return not self.impossible

    @cached_property
    def impossible(self) -> tuple[int, ...]:
        """Which causes do surely less than nothing, as friction that drives or a mass that lifts, or more than any such thing does.

        A small part of a cause may do less: it mends the form of the law, which nobody knows better. What ends where its range does
        stands in for something else.
        """
        out = []
        c = self.comparison
        arm, norm = c.linearisation.hypothesis.arm, np.sqrt(np.diag(c.products))
        told = zip(self.causes, self.columns_of_causes, self.sigma_of_causes, strict=True)
        for i, (cause, columns, sigma) in enumerate(told):
            bounds, count = cause.effect.lower_bounds(arm)[list(cause.where.columns)], len(cause.amounts)
            does = cause.amounts / cause.sizes(arm)[:count] * norm[columns[:count]]
            beyond = cause.amounts < bounds - IMPOSSIBLE_SIGMAS * sigma[:count]
            is_opposed = np.any(beyond & (np.abs(does) > MAX_OPPOSED_SHARE * np.linalg.norm(does)))
            if is_opposed or np.any(cause.amounts >= cause.effect.upper_bounds(arm)[list(cause.where.columns)]):
                out.append(i)
        return tuple(out)

    @cached_property
    def untold(self) -> tuple[int, ...]:
        """Which causes the recordings do not tell from nothing: no amount stands clear of its sigma, on the side it may be on."""
        return self.untold_with(1.0)

    @cached_property
    def untold_beside_what_is_left(self) -> tuple[int, ...]:
        """The same where what is left above noise widens each sigma, as it is told."""
        return self.untold_with(max(1.0, float(self.excess.ratio.max())))

    def untold_with(self, widening: float) -> tuple[int, ...]:
        """As `untold`, with sigmas so many times as wide."""
        arm, out = self.comparison.linearisation.hypothesis.arm, []
        for i, (cause, sigma) in enumerate(zip(self.causes, self.sigma_of_causes, strict=True)):
            from_nothing = cause.effect.lower_bounds(arm)[list(cause.where.columns)] == 0
            does = np.where(from_nothing, cause.amounts, np.abs(cause.amounts))
            if np.all(does < UNTOLD_SIGMAS * widening * sigma[: len(does)]):
                out.append(i)
        return tuple(out)

    @cached_property
    def columns_of_causes(self) -> tuple[NDArray[np.intp], ...]:
        """Of each cause in the comparison: its amounts, then its shape terms."""
        arm = self.comparison.linearisation.hypothesis.arm
        counts = [len(cause.sizes(arm)) for cause in self.causes]
        return tuple(np.split(self.comparison.cause_columns, np.cumsum(counts)[:-1])) if counts else ()

    @cached_property
    def loss(self) -> float:
        """Of blocks where all but their fold were fitted, of nuisances beyond tolerance, and what a last step would have taken."""
        return float(self.comparison.block_losses().sum()) + self.comparison.prior_loss() + max(0.0, self._missed)

    @property
    def _missed(self) -> float:
        """What a last step would take from the loss, by straight lines."""
        return self.comparison.profiled_loss - self.fit.loss

    @property
    def is_astray(self) -> bool:
        """Whether a straight step promises far more than the fit has found: it ended, but nowhere near a least loss."""
        return self._missed > MAX_MISSED * self.noise_loss

    @property
    def surplus(self) -> float:
        """Loss beyond what noise alone makes, which differs from stage to stage: a heavier arm makes more of the angles' noise.

        Of all blocks as they were fitted: what a single one of them tells may be anything where that is left out. Noise far beyond
        the weights' is no excuse: laws that are wrong may make much of the rounding of counts."""
        return self.comparison.profiled_loss - min(self.noise_loss, _FAR * self.comparison.row_count)

    @cached_property
    def held_share(self) -> float:
        """What is seen of dry friction that holds joints at rest."""
        at = self.comparison.linearisation
        excess = [
            (residual**2 - np.mean(np.square(draws), axis=0))[at.hypothesis.arm.M :]
            for residual, draws in zip(self.comparison.residuals_after(self.fit), self.noise, strict=True)
        ]
        beyond = held_share(excess, [square_at_rows(r.held, r.signals) for r in at.recordings])
        return float(np.clip(at.hypothesis.held_share + beyond, 0.0, 1.0))

    @cached_property
    def excess(self) -> NoiseExcess:
        """What stands above noise."""
        variance = [recording.input_variance for recording in self.comparison.linearisation.recordings]
        return noise_excess(self.judged_residuals, self.judged_noise, variance)

    @cached_property
    def judged_residuals(self) -> list[Array]:
        """What is left of each recording, (C, S), as it is judged."""
        residuals = self.comparison.residuals_after(self.fit)
        return [
            judged(r, at.signals) for r, at in zip(residuals, self.comparison.linearisation.recordings, strict=True)
        ]

    @cached_property
    def judged_noise(self) -> list[list[Array]]:
        """Draws of noise alone of each recording, (C, S), as they are judged."""
        recordings = self.comparison.linearisation.recordings
        return [[judged(d, at.signals) for d in draws] for draws, at in zip(self.noise, recordings, strict=True)]


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

    def fitted(self, start: Linearisation, causes: tuple[Cause, ...]) -> FitStage:
        """Fitted with these causes, whose shapes are where the fit begins, from a linearisation on; each choice is fitted once."""
        key = tuple((c.effect.name, c.where.label, *sorted(c.shape.items())) for c in causes)
        if key not in self._stages:
            stage = self._stage(start, causes)
            if stage.is_astray and start is not self._start:
                # along a bent valley a fit may end anywhere: one that begins where no other has been may not
                stage = min(stage, self._stage(self._start, causes), key=lambda stage: stage.surplus)
            self._stages[key] = stage
        return self._stages[key]

    @property
    def ensembles(self) -> Sequence[NoiseEnsemble]:
        """Of the recordings, with the motors' speeds by the base model."""
        return self._ensembles

    @property
    def hypothesis(self) -> Hypothesis:
        """To which causes are added, with what is seen of dry friction that holds joints at rest."""
        return self._h

    def is_ill_weighted(self, stage: FitStage) -> bool:
        """Whether noise with a stage's laws is plainly louder or softer than the weights by which it was fitted say.

        Or whether dry friction is seen to hold joints at rest by more, or by less."""
        level = stage.noise_loss / stage.comparison.row_count
        holds_otherwise = abs(stage.held_share - self._h.held_share) > _MAX_HELD_CHANGE
        return holds_otherwise or not 1 / _MAX_NOISE_CHANGE < level < _MAX_NOISE_CHANGE

    def reweighted(self, stage: FitStage) -> "tuple[CauseFitter, FitStage]":
        """The same causes fitted anew with noise as it is with them, and what fits others so."""
        return self._reweighted(stage, self._whitener(stage))

    def reweighted_by_what_is_left(self, stage: FitStage) -> "tuple[CauseFitter, FitStage]":
        """As `reweighted`, where a channel with more than noise counts by what it has.

        Else clocks and friction would give way to what no number mends where a law's form leaves something."""
        fitter, stage = self.reweighted(stage) if self.is_ill_weighted(stage) else (self, stage)
        at, whiten = stage.comparison.linearisation, fitter._whitener(stage)
        residuals = zip(at.recordings, stage.comparison.residuals_after(stage.fit), strict=True)
        white = [whiten(r, segment_starts(rec.signals), rec.input_variance) for rec, r in residuals]
        level = np.sqrt(np.mean(np.concatenate(white, axis=1) ** 2, axis=1))
        return fitter._reweighted(stage, whiten.rescaled(np.maximum(level, 1.0)))

    def finished(self, stage: FitStage) -> FitStage:
        """With the steps that were too small to be taken while causes were chosen: they may be a sigma of a cause's numbers."""
        current, causes, at = stage.comparison, stage.causes, stage.comparison.linearisation
        data = [replace(d, speeds=r.signals.speeds) for d, r in zip(self._data, at.recordings, strict=True)]
        for _ in range(_MAX_LAST_STEPS):
            if _promised(current) < _LEAST_LAST_PROMISE:
                break
            candidate, stepped = _after_step(current, 0.0, self._h, causes, data, self.whiten)
            if _promised(candidate) > _promised(current):
                break
            current, causes = candidate, stepped
        # numbers of causes stay where they are in the model that is written: the others are the best beside these
        return replace(stage, comparison=current, causes=causes, fit=last_fit(current, current.cause_columns))

    def _whitener(self, stage: FitStage) -> Whitener:
        at = stage.comparison.linearisation
        starts = [segment_starts(recording.signals) for recording in at.recordings]
        return noise_whitener(steady_noise_residuals(at, self._ensembles), starts, self._h.arm.M)

    def _reweighted(self, stage: FitStage, whiten: Whitener) -> "tuple[CauseFitter, FitStage]":
        other = copy(self)
        other.whiten, other._stages, other._h = whiten, {}, replace(self._h, held_share=stage.held_share)
        return other, other.fitted(stage.comparison.linearisation, stage.causes)

    def _stage(self, start: Linearisation, causes: tuple[Cause, ...]) -> FitStage:
        passes, ensembles = _speed_passes(with_causes(self._h, causes)), self._ensembles
        if passes:
            comparison, causes, ensembles = self._refined_with_speeds(start, causes, passes)
        else:
            comparison, causes = _refined(start, self._h, causes, self._data, self.whiten)
        at = comparison.linearisation
        noise = noise_residuals(at, ensembles)
        return FitStage(comparison, causes, tuple(noise), noise_loss(noise, at, self.whiten), last_fit(comparison))

    def _refined_with_speeds(
        self, near: Linearisation, causes: tuple[Cause, ...], passes: int, before: float = np.inf
    ) -> tuple[Comparison, tuple[Cause, ...], list[NoiseEnsemble]]:
        """As `_refined`, with speeds by the causes' laws: told with the base model's friction they would speak for that.

        passes: of telling speeds and fitting, at most; before: the loss that was left so far."""
        if np.isinf(before) and not near.machine.remembers_path:
            rough, causes = _refined(near, self._h, causes, self._data, self.whiten, rough=True)
            near, before = rough.linearisation, rough.profiled_loss
        ensembles = _with_speeds(self._ensembles, near)
        data = [ensemble.data for ensemble in ensembles]
        comparison, causes = _refined(near, self._h, causes, data, self.whiten)
        loss = comparison.profiled_loss
        if passes == 1 or abs(loss / before - 1) < _MIN_LOSS_GAIN_FAR:
            return comparison, causes, ensembles
        return self._refined_with_speeds(comparison.linearisation, causes, passes - 1, loss)


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


def _refined(
    start: Linearisation,
    h: Hypothesis,
    causes: tuple[Cause, ...],
    data: Sequence[DataSet],
    whiten: Whitener,
    rough: bool = False,
) -> tuple[Comparison, tuple[Cause, ...]]:
    """The base model's numbers, the causes' and doubtful clocks fitted together, by Levenberg and Marquardt's steps.

    What nuisances do changes little on the way: it is told anew where a round of steps has ended. rough: one short round."""
    at = _linearised(start, with_causes(h, causes), data, start.p, start.frame_lags)
    current = compare(at, causes, (), nuisances_at(at), whiten)
    for _ in range(1 if rough else _MAX_ROUNDS):
        before = current.profiled_loss
        if _promised(current) < _least_promise(current):
            break
        stepped, causes = _stepped_down(current, h, causes, data, whiten, _FIRST_STEPS if rough else _MAX_STEPS)
        if rough:
            return stepped, causes
        at = stepped.linearisation
        current = compare(at, causes, (), nuisances_at(at), whiten)
        if abs(current.profiled_loss / before - 1) < _least_loss_gain(current):
            break
    return current, causes


def _stepped_down(
    current: Comparison,
    h: Hypothesis,
    causes: tuple[Cause, ...],
    data: Sequence[DataSet],
    whiten: Whitener,
    max_steps: int,
) -> tuple[Comparison, tuple[Cause, ...]]:
    """One round of steps, with nuisances that act as where it begins."""
    damping, was_small, best = 0.0, False, (current, causes)
    for _ in range(max_steps):
        if _promised(current) < _least_promise(current):
            break
        candidate, stepped = _after_step(current, damping, h, causes, data, whiten)
        gain = _gain(candidate, current)
        is_short = gain < _SHORT_GAIN * _promised(current) / current.profiled_loss
        if is_short and damping == 0 and any(cause.shape for cause in stepped):
            settled, so_far = _settled(candidate, h, stepped, data, whiten)
            if _gain(settled, current) > gain:
                candidate, stepped, gain = settled, so_far, _gain(settled, current)
        if gain > 0 or _is_nearer(candidate, current):
            current, causes = candidate, stepped
            best = min(best, (current, causes), key=lambda at: at[0].profiled_loss)
            damping = damping / _DAMPING_DECREASE if damping > _FIRST_DAMPING else 0.0
            is_small = gain < _least_loss_gain(current)
            if is_small and (damping == 0 or was_small):
                break
            was_small = is_small
        elif _promised(current) < _least_loss_gain(current) * current.profiled_loss:
            break
        else:
            damping = max(_FIRST_DAMPING, _DAMPING_INCREASE * damping)
            if damping > _MAX_DAMPING:
                break
    # steps along a bent valley may leave it for good
    return best if current.profiled_loss > _LOST * best[0].profiled_loss else (current, causes)


def _gain(candidate: Comparison, current: Comparison) -> float:
    """Share of the loss that a step took away.

    The base model's numbers are all but linear: they follow what the causes' are, in the next step."""
    return 1 - min(
        candidate.profiled_loss / current.profiled_loss,
        candidate.loss_with_fixed_causes / current.loss_with_fixed_causes,
    )


def _settled(
    stepped: Comparison, h: Hypothesis, causes: tuple[Cause, ...], data: Sequence[DataSet], whiten: Whitener
) -> tuple[Comparison, tuple[Cause, ...]]:
    """Where a step led to, all numbers at their best for the shapes there.

    Of a shape and the amounts that go with it the loss is a narrow, bent valley: along its tangent a step leaves it."""
    current = stepped
    for _ in range(_SETTLING_STEPS):
        first, columns = current.base_count + current.nuisance_count, []
        for cause in causes:
            count = len(cause.sizes(current.linearisation.hypothesis.arm))
            columns += range(first + len(cause.amounts), first + count)
            first += count
        held = current.with_held(np.array(columns, dtype=np.intp))
        if _promised(held) < _least_promise(held):
            break
        current, causes = _after_step(held, 0.0, h, causes, data, whiten)
    return current, causes


def _after_step(
    current: Comparison,
    damping: float,
    h: Hypothesis,
    causes: tuple[Cause, ...],
    data: Sequence[DataSet],
    whiten: Whitener,
) -> tuple[Comparison, tuple[Cause, ...]]:
    """Where a damped step leads to, with the same nuisances."""
    fit = current.fit(damping=damping)
    nuisances_end = current.base_count + current.nuisance_count
    step = np.append(fit.numbers[: current.base_count], fit.numbers[nuisances_end:])
    at = current.linearisation
    p, stepped = _stepped(at, causes, step)
    lags = at.frame_lags
    if current.clock_relaxed:
        shifts = current.clock_shifts(fit)
        lags = lags + np.where(np.abs(shifts) > _MIN_CLOCK_STEP_S, shifts, 0.0)
    linearised = _linearised(at, with_causes(h, stepped), data, p, lags)
    return compare(linearised, stepped, (), current.nuisances, whiten), stepped


def _is_nearer(candidate: Comparison, current: Comparison) -> bool:
    """Whether a step that did not lessen the loss led to where its columns promise little more.

    Near noise the loss is no judge: a heavier arm makes more of the angles' noise. Columns are of smooth motions, free of it."""
    is_near = candidate.profiled_loss < _FAR * candidate.row_count
    return is_near and _promised(candidate) < _NEARER_SHARE * _promised(current)


def _promised(current: Comparison) -> float:
    """What a straight step would take from the loss."""
    return current.profiled_loss - current.fit().loss


def last_fit(current: Comparison, held: Sequence[int] | Index = ()) -> ColumnFit:
    """The fit with which steps end, a straight one: but columns that are held (k,), and numbers that it would take far, stay.

    A number that acts by its ratio, as the speed over which friction turns over, goes anywhere by a straight step where nothing
    tells it, and may do much there to other recordings. An arm far beyond what its drawing is good for is not the one drawn.
    """
    fit, u = current.fit(), current.linearisation.unknowns
    step, value = np.abs(u.size * fit.numbers[: current.base_count]), current.linearisation.p
    acts_by_ratio = np.array([entry.term.low > 0 for entry in u.entries])
    far = np.flatnonzero(acts_by_ratio & (step > _MAX_LAST_CHANGE * value))
    return current.with_held(np.append(np.asarray(held, dtype=np.intp), far)).fit_within(MAX_TOLERANCES)


def _least_loss_gain(current: Comparison) -> float:
    """Share of the loss below which a step was the last."""
    return _MIN_LOSS_GAIN_FAR if current.profiled_loss > _FAR * current.row_count else _MIN_LOSS_GAIN


def _least_promise(current: Comparison) -> float:
    """Below which no step is taken."""
    return max(_MIN_PROMISE, _MIN_PROMISE_SHARE * (current.profiled_loss - current.row_count))


def _with_speeds(ensembles: Sequence[NoiseEnsemble], at: Linearisation) -> list[NoiseEnsemble]:
    """Ensembles with motor speeds by the laws and delays of a linearisation."""
    return [e.with_motor_speeds(at.machine, r.delay) for e, r in zip(ensembles, at.recordings, strict=True)]


def _speed_passes(h: Hypothesis) -> int:
    """How often speeds are told anew: where a law beyond the base changes what force turns the motors, or remembers their path."""
    laws = [type(law_named(name)) for name in h.laws]
    if any(law.remembers_path for law in laws):
        return _PATH_PASSES
    return int(any(law.friction is not Law.friction or law.acting_force is not Law.acting_force for law in laws))


def _linearised(
    nearby: Linearisation, h: Hypothesis, data: Sequence[DataSet], p: Array, frame_lags: Array
) -> Linearisation:
    """A linearisation; where only laws differ from one nearby, its recordings as they were read."""
    old = nearby.hypothesis
    p = nearby.unknowns.carried(p, base_unknowns(h, len(data)))
    reading = (h.neck, h.frame_lag, h.motor_angle_lag, *h.angle_error, *frame_lags)
    same_speeds = all(r.signals.speeds is d.speeds for r, d in zip(nearby.recordings, data, strict=True))
    if not same_speeds or reading != (
        old.neck,
        old.frame_lag,
        old.motor_angle_lag,
        *old.angle_error,
        *nearby.frame_lags,
    ):
        return linearise(h, corrected_signals(h, data, frame_lags), p, frame_lags)
    return with_laws_of(nearby, h, p)


def _stepped(at: Linearisation, causes: tuple[Cause, ...], step: Array) -> tuple[Array, tuple[Cause, ...]]:
    """The base model's numbers and the causes, moved by a step in their sizes."""
    u, arm = at.unknowns, at.hypothesis.arm
    base_step, rest = np.split(step, [len(u.size)])
    p, stepped = np.clip(at.p + u.size * base_step, u.low, u.high), []
    for cause in causes:
        cause_step, rest = np.split(rest, [len(cause.sizes(arm))])
        stepped.append(cause.stepped(cause_step, arm))
    return p, tuple(stepped)
