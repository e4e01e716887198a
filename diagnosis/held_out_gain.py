"""What an extended model gains where it was not fitted: the same equations on other recordings, before, after, and noise alone."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.compare import compare
from diagnosis.comparison import ColumnFit, Comparison
from diagnosis.fit_stage import FitStage
from diagnosis.hypothesis import Hypothesis
from diagnosis.judged_rows import judged
from diagnosis.linearisation import Linearisation, corrected_signals, linearise
from diagnosis.noise_ensemble import NoiseEnsemble, noise_residuals
from diagnosis.noise_excess import NoiseExcess, row_weights
from diagnosis.nuisances import nuisances_at
from identification.unknowns import unknowns
from identification.whitening import Whitener

Array = NDArray[np.float64]

EQUATIONS = ("motor equations", "arm equations")

_MAX_STEPS = 6
_MIN_STEP, _MIN_CLOCK_STEP_S = 0.02, 2e-5
"""in sizes of the numbers, and of a clock, s: steps that are smaller need not be taken"""
_SHORTER = 0.25
"""a step that does not lessen the loss is tried again, so much shorter"""
_BLOCKS = 30
"""of rows, each left out in turn for the gain's sigma"""


@dataclass(frozen=True)
class HeldOutResiduals:
    """Of recordings that were not fitted; rows weighted as `row_weights` says."""

    residuals: tuple[Array, ...]
    """of each recording, (C, S)"""
    noise: tuple[list[Array], ...]
    """draws of noise alone, of each recording"""
    uncertain: tuple[Array, ...]
    """variance by what the fit left uncertain of its numbers, of each recording, (C, S)"""
    frame_lags: tuple[float, ...]
    """s, as in Linearisation"""
    times: tuple[Array, ...]
    """of each recording's rows, (S,), s from its start"""


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


def held_out_residuals(
    stage: FitStage, ensembles: Sequence[NoiseEnsemble], whiten: Whitener, clock_relaxed: bool
) -> HeldOutResiduals:
    """Of recordings read with a stage's causes and numbers; pre-elongation, delay and clock are each recording's own.

    clock_relaxed: whether clocks are in doubt because the base model's laws are wrong."""
    fitted, fit, h, causes = stage.comparison, stage.fit, stage.hypothesis, stage.causes
    residuals, noise, uncertain, frame_lags, times = [], [], [], [], []
    for recording in ensembles:
        ensemble = recording.with_motor_speeds(fitted.linearisation.machine, fitted.linearisation.recordings[0].delay)
        at = _transferred(fitted.linearisation, fit, h, ensemble)
        comparison, own_fit = _with_own_numbers(
            at, ensemble, partial(_with_fitted_arm, fitted, fit, whiten, clock_relaxed)
        )
        at = comparison.linearisation
        (read,) = at.recordings
        residual = judged(comparison.residuals_after(own_fit)[0], read.signals)
        draws = [judged(d, read.signals) for d in noise_residuals(at, [ensemble])[0]]
        (weights,) = row_weights([draws], [read.input_variance])
        residuals.append(weights * residual)
        noise.append([weights * d for d in draws])
        with_causes = compare(at, causes, (), comparison.nuisances, whiten, clock_relaxed=clock_relaxed)
        uncertain.append(weights**2 * _uncertainty(with_causes, fitted, fit))
        frame_lags.append(float(at.frame_lags[0]))
        times.append(read.signals.kept_time)
    return HeldOutResiduals(tuple(residuals), tuple(noise), tuple(uncertain), tuple(frame_lags), tuple(times))


def _with_own_numbers(
    at: Linearisation, ensemble: NoiseEnsemble, compared: Callable[[Linearisation], tuple[Comparison, ColumnFit]]
) -> tuple[Comparison, ColumnFit]:
    """A recording at the pre-elongations, delay and clock that suit it best, by steps each of which lessens its loss.

    compared: a linearisation, with the arm's nuisances as they were fitted, and the fit of what the recording has for itself.
    """
    current, own_fit = compared(at)
    for _ in range(_MAX_STEPS):
        step, of_base = np.zeros(current.base_count), own_fit.columns < current.base_count
        step[own_fit.columns[of_base]] = own_fit.numbers[of_base]
        shifts = current.clock_shifts(own_fit)
        share = 1.0
        while np.any(np.abs(share * step) >= _MIN_STEP) or np.any(np.abs(share * shifts) >= _MIN_CLOCK_STEP_S):
            at = current.linearisation
            lags = at.frame_lags + share * shifts
            signals = corrected_signals(at.hypothesis, [ensemble.data], lags)
            candidate = compared(linearise(at.hypothesis, signals, at.p + share * at.unknowns.size * step, lags))
            if candidate[0].loss_with_clocks_at_best < current.loss_with_clocks_at_best:
                break
            share *= _SHORTER  # of laws that bend a whole step may lead to slack cables
        else:
            break
        current, own_fit = candidate
    return current, own_fit


def _uncertainty(at: Comparison, fitted: Comparison, fit: ColumnFit) -> Array:
    """Variance of a recording's residuals, (C, S), as they are judged, by what the fit left uncertain of the arm and its laws.

    Of another motion the same numbers ask other things. What the recording's own numbers make good for is not in it."""
    common = [i for i, e in enumerate(fitted.linearisation.unknowns.entries) if e.recording is None]
    there = [i for i, e in enumerate(at.linearisation.unknowns.entries) if e.recording is None]
    count = fitted.nuisances.count
    known = np.concatenate([common, fitted.base_count + np.arange(count), fitted.cause_columns]).astype(int)
    asked = np.concatenate([there, at.base_count + np.arange(count), at.cause_columns]).astype(int)
    rows = np.searchsorted(fit.columns, known)
    value, direction = np.linalg.eigh(fitted.plain_covariance(fit)[np.ix_(rows, rows)])
    root = direction * np.sqrt(np.maximum(value, 0.0))
    own = at.fit_of_recordings().columns
    made_good = at.answer(own, asked) @ root
    (matrix,), (read,) = at.matrices, at.linearisation.recordings
    change = matrix[..., asked] @ root - matrix[..., own] @ made_good
    return np.sum([judged(change[..., k], read.signals) ** 2 for k in range(change.shape[2])], axis=0)


def _with_fitted_arm(
    fitted: Comparison, fit: ColumnFit, whiten: Whitener, clock_relaxed: bool, at: Linearisation
) -> tuple[Comparison, ColumnFit]:
    """A recording with the arm's nuisances as they were fitted, and the fit of what it has for itself only."""
    count = fitted.nuisances.count
    comparison = compare(at, (), (), nuisances_at(at), whiten, clock_relaxed=clock_relaxed)
    numbers = np.zeros(len(comparison.prior_sigma))
    first = comparison.base_count
    numbers[first : first + count] = fit.numbers[fitted.base_count : fitted.base_count + count]
    comparison = comparison.with_fixed(numbers)
    return comparison, comparison.fit_of_recordings()


def gains(before: HeldOutResiduals, after: HeldOutResiduals, motors: int) -> tuple[Gain, ...]:
    """Of the motors' and of the arm's equations."""
    out = []
    for measure, unit, part in zip(EQUATIONS, ("N", "N m"), (slice(0, motors), slice(motors, None)), strict=True):
        old, new = (np.concatenate([r[part] for r in side.residuals], axis=1) for side in (before, after))
        floor = float(np.sqrt(np.mean(_floor_square(after)[part])))
        rms = [*(float(np.sqrt(np.mean(values**2))) for values in (old, new)), floor]
        blocks = np.array_split(np.arange(old.shape[1]), _BLOCKS)
        jackknife = [
            np.sqrt(np.mean(np.delete(old, b, axis=1) ** 2)) - np.sqrt(np.mean(np.delete(new, b, axis=1) ** 2))
            for b in blocks
        ]
        sigma = float(np.sqrt((_BLOCKS - 1) * np.var(jackknife)))
        out.append(Gain(measure=measure, unit=unit, before=rms[0], after=rms[1], noise_floor=rms[2], sigma=sigma))
    return tuple(out)


def held_out_excess(side: HeldOutResiduals, noise: HeldOutResiduals) -> NoiseExcess:
    """How far recordings that were not fitted stand above noise, channel by channel."""
    residuals = np.concatenate(side.residuals, axis=1)
    return NoiseExcess(np.sqrt(np.mean(residuals**2, axis=1)), np.sqrt(_floor_square(noise)))


def _floor_square(side: HeldOutResiduals) -> Array:
    """What a true model would leave of each channel, squared, (C,): noise, and what the fit left uncertain of its numbers."""
    drawn = np.concatenate([d for draws in side.noise for d in draws], axis=1)
    return np.mean(drawn**2, axis=1) + np.mean(np.concatenate(side.uncertain, axis=1), axis=1)


def _transferred(fitted: Linearisation, fit: ColumnFit, h: Hypothesis, ensemble: NoiseEnsemble) -> Linearisation:
    """The fitted numbers at another recording, which starts with the first one's pre-elongation and delay."""
    fitted_p = fitted.p + fitted.unknowns.size * fit.numbers[: len(fitted.p)]
    u = unknowns(h.arm, fitted.unknowns.laws, 1, dict(fitted.unknowns.held))
    p = u.start()
    for (name, recording), slot in u.slots.items():
        p[slot] = fitted_p[fitted.unknowns.slots[name, recording]]
    frame_lags = np.zeros(1)
    return linearise(h, corrected_signals(h, [ensemble.data], frame_lags), p, frame_lags)
