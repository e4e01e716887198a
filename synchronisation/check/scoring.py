"""How much each fault would explain of what healthy cables leave, and how much noise would explain as well.

Rows are whitened with the full covariance of each frame: vision's noise through Z, which all cables share, and each cable's own
error, which is estimated. The law's factors, and the numbers of the drawing within their tolerance, are projected out under their
priors. Correlation in time enters through blocks.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm
from scipy.stats import t as student

from mechanism.cable_lengths import Z
from synchronisation.check.absolute_law import BETA_SIGMA
from synchronisation.check.faults import FAULTS
from synchronisation.check.observation import ElongationObservation
from synchronisation.check.signatures import FaultCandidate, tolerated
from synchronisation.error_sizes import likelier_sizes

Array = NDArray[np.float64]

INITIAL_ERROR_M, MIN_ERROR_M = 2e-5, 3e-6
"""m: a cable's own error before it is estimated, and the smallest estimate (docs/thresholds.md)"""
LAW_FITS, ERROR_STEPS = 3, 15
"""fits of the law, and steps of each cable's own error after each"""
DRIFT_TERMS, DRIFT_SIGMA_M = 8, 5e-6
"""half waves over the recording by which a healthy cable may drift, and the standard deviation of each, m (docs/thresholds.md)"""
BLOCK_S = 2.0
"""s within which residuals may be correlated (docs/thresholds.md)"""
MIN_INFORMATION_SHARE = 1e-9
"""share of a signature's information that the law, and faults fitted along, must leave for its size to be estimated
(docs/thresholds.md)"""
FALSE_ALARM_RATE, DRAWS = 0.005, 2000
"""share of healthy recordings in which a fault may be named, and the draws that the threshold is computed from
(docs/thresholds.md)"""
_SCORED_AT_ONCE = 32
"""candidates whose signatures are whitened together: all of a long recording's would be most of memory"""


@dataclass(frozen=True)
class LawPrior:
    """Factors of the law and numbers of the drawing, (M P + K,), as another recording gave them, with their covariance."""

    beta: Array
    covariance: Array


@dataclass(frozen=True)
class LawFit:
    """A fit of the law of all cables, with the nuisances and the faults that were fitted along; p unknowns in all."""

    whiten: Array
    """(F, M, M): lower triangular, brings the rows of one frame to unit variance"""
    A: Array
    """whitened regressors of all unknowns, (F M, p)"""
    prior: Array
    """(p, p), precision"""
    inverse: Array
    """of the normal matrix, (p, p)"""
    beta: Array
    """all unknowns, (p,), those of the law first, and then those of the drawing"""
    of_arm: int
    """M P + K, how many these are"""
    whitened_residuals: Array
    """(F M,)"""
    error: Array
    """each cable's own error, (M,), m"""
    blocks: NDArray[np.intp]
    """rows at which blocks begin"""
    residuals: Array
    """(F, M), m"""
    with_baseline: bool

    def whitened(self, signatures: Array) -> Array:
        """Signatures (F, M, C) as whitened rows, (F M, C)."""
        return (self.whiten @ signatures).reshape(-1, signatures.shape[-1])


@dataclass(frozen=True)
class CandidateScore:
    """Estimated size of a candidate, and how significant it is."""

    candidate: FaultCandidate
    size: float
    sigma: float
    gain: float
    """decrease of chi-square"""
    block_parts: Array
    """what every block adds to the size, over sigma, (B,)"""
    prior_part: float
    """the part of sigma that comes from priors, over sigma"""
    tolerance: float
    """size up to which an arm counts as healthy"""

    @property
    def z(self) -> float:
        """By how many sigma the size exceeds what a healthy arm may have."""
        return max(abs(self.size) - self.tolerance, 0.0) / self.sigma


@dataclass(frozen=True)
class _Unknowns:
    """Regressors D (F, M, p) of the law, the faults fitted along and the nuisances, with their prior mean and precision."""

    D: Array
    mean: Array
    """(p,)"""
    precision: Array
    """(p, p)"""
    of_arm: int
    """how many are of the law and of the drawing, the first ones"""


def fit_law(
    observation: ElongationObservation,
    prior: LawPrior | None = None,
    faults: Sequence[Array] = (),
    error: Array | None = None,
) -> LawFit:
    """The law fitted under its own prior or a baseline's; signatures (F, M) of `faults` are fitted along without a prior.

    error: each cable's own, (M,), m, where it is not to be estimated.
    """
    F, M = observation.x.shape
    unknowns = _unknowns(observation, prior, faults)
    vision = observation.vision
    law_fits = LAW_FITS if error is None else 0
    error = np.full(M, INITIAL_ERROR_M) if error is None else error
    own, cables = np.broadcast_to(np.eye(M), (F, M, M)), np.arange(M)
    y, whiten, A, inverse, beta = _solve(observation.x, vision, error, unknowns)
    for _ in range(law_fits):
        error = likelier_sizes(observation.x - unknowns.D @ beta, own, cables, error, MIN_ERROR_M, ERROR_STEPS, vision)
        y, whiten, A, inverse, beta = _solve(observation.x, vision, error, unknowns)
    time = observation.time
    starts = np.searchsorted(time, np.arange(time[0], time[-1], BLOCK_S)) * M
    return LawFit(
        whiten=whiten,
        A=A,
        prior=unknowns.precision,
        inverse=inverse,
        beta=beta,
        of_arm=unknowns.of_arm,
        whitened_residuals=y - A @ beta,
        error=error,
        blocks=np.unique(starts[starts < F * M]),
        residuals=observation.x - unknowns.D @ beta,
        with_baseline=prior is not None,
    )


def adjusted(observation: ElongationObservation, fit: LawFit) -> ElongationObservation:
    """The observation with angles adjusted to the cables, whose law leaves what the angles' noise and the cables' own errors make.

    The adjusted observations of least squares with conditions between them (Gauss-Helmert).
    """
    covariance = observation.vision + np.diag(fit.error**2)
    share = np.linalg.solve(covariance, fit.residuals[..., None])[..., 0]
    noise = -observation.variance * np.einsum("tij,tj->ti", Z(observation.arm, observation.alpha), share)
    return replace(observation, adjusted=observation.alpha - noise)


def _unknowns(observation: ElongationObservation, prior: LawPrior | None, faults: Sequence[Array]) -> _Unknowns:
    M, P = observation.x.shape[1], observation.law.X.shape[2]
    columns = [np.eye(M)[j] * observation.law.X[:, j, p][:, None] for j in range(M) for p in range(P)]
    drawing = tolerated(observation)
    columns += [signature for signature, _ in drawing]
    of_arm = len(columns)
    sigma = np.concatenate([np.tile(BETA_SIGMA, M), [sigma for _, sigma in drawing]])
    mean, arm_precision = np.zeros(of_arm), np.diag(sigma**-2.0)
    if prior is not None:
        mean, arm_precision = prior.beta, np.linalg.inv(prior.covariance)
    # signatures with the precision of their size: faults, constant errors of angles, the clock's error, slow drift of cables
    further: list[tuple[Array, float]] = [(s, 0.0) for s in faults]
    slope, common = -Z(observation.arm, observation.adjusted), observation.common
    further += [(slope[:, i], 1 / common[i] ** 2) for i in range(observation.arm.N) if common[i] > 0]
    if observation.clock_sigma > 0:
        further.append((observation.theta_d * observation.arm.drum, observation.clock_sigma**-2.0))
    phase = np.pi * (observation.time - observation.time[0])[:, None] / np.ptp(observation.time)
    for k in range(1, DRIFT_TERMS + 1):
        further += [(np.cos(k * phase) * cable, DRIFT_SIGMA_M**-2.0) for cable in np.eye(M)]
    D = np.stack([*columns, *(s for s, _ in further)], axis=-1)
    precision = np.zeros((D.shape[-1],) * 2)
    precision[:of_arm, :of_arm] = arm_precision
    precision[range(of_arm, len(precision)), range(of_arm, len(precision))] = [p for _, p in further]
    return _Unknowns(D, np.concatenate([mean, np.zeros(len(further))]), precision, of_arm)


def _solve(x: Array, vision: Array, error: Array, unknowns: _Unknowns) -> tuple[Array, Array, Array, Array, Array]:
    """Whitened elongations (F M,), what whitens (F, M, M), whitened regressors (F M, p), inverse normal matrix, and unknowns."""
    whiten = np.asarray(np.linalg.inv(np.linalg.cholesky(vision + np.diag(error**2))), dtype=float)
    A = (whiten @ unknowns.D).reshape(x.size, -1)
    y = np.einsum("tjk,tk->tj", whiten, x).ravel()
    inverse = np.asarray(np.linalg.inv(A.T @ A + unknowns.precision), dtype=float)
    return y, whiten, A, inverse, inverse @ (A.T @ y + unknowns.precision @ unknowns.mean)


def score_candidates(fit: LawFit, candidates: Sequence[FaultCandidate]) -> list[CandidateScore]:
    """How much each candidate, alone, would explain of what the law leaves."""
    parts = (candidates[begin : begin + _SCORED_AT_ONCE] for begin in range(0, len(candidates), _SCORED_AT_ONCE))
    return [score for part in parts for score in _scored_together(fit, part)]


def _scored_together(fit: LawFit, candidates: Sequence[FaultCandidate]) -> list[CandidateScore]:
    S = fit.whitened(np.stack([candidate.signature for candidate in candidates], axis=-1))
    Q = fit.inverse @ (fit.A.T @ S)
    free = S - fit.A @ Q
    by_prior = np.einsum("pc,pc->c", Q, fit.prior @ Q)
    information = np.einsum("rc,rc->c", free, free) + by_prior
    estimable = information > MIN_INFORMATION_SHARE * np.einsum("rc,rc->c", S, S)
    information = np.where(estimable, information, 1.0)
    size = fit.whitened_residuals @ S / information
    # the residual with this fault fitted shows how much correlated noise moves its size
    parts = np.add.reduceat(free * (fit.whitened_residuals[:, None] - size * free), fit.blocks, axis=0)
    variance = np.maximum(np.sum(parts**2, axis=0) + by_prior, information)
    spread = np.sqrt(variance)
    scores = []
    for k, candidate in enumerate(candidates):
        if not estimable[k] or size[k] < candidate.smallest or abs(size[k]) > candidate.largest:
            scores.append(_unestimable(candidate, len(fit.blocks)))
            continue
        fault = FAULTS[candidate.fault]
        healthy = fault.tolerance_with_baseline if fit.with_baseline else fault.tolerance
        scores.append(
            CandidateScore(
                candidate=candidate,
                size=float(size[k]),
                sigma=float(spread[k] / information[k]),
                gain=float(size[k] ** 2 * information[k]),
                block_parts=parts[:, k] / spread[k],
                prior_part=float(np.sqrt(by_prior[k] / variance[k])),
                tolerance=healthy * candidate.healthy_unit,
            )
        )
    return scores


def _unestimable(candidate: FaultCandidate, blocks: int) -> CandidateScore:
    """Of a candidate whose signature the law takes up whole, or that would have to be larger or smaller than it can be."""
    return CandidateScore(
        candidate=candidate,
        size=0.0,
        sigma=np.inf,
        gain=0.0,
        block_parts=np.zeros(blocks),
        prior_part=0.0,
        tolerance=0.0,
    )


def threshold(scores: Sequence[CandidateScore]) -> float:
    """The z above which the largest of all scores lies in FALSE_ALARM_RATE of healthy recordings.

    Draws take the blocks of this recording's residuals with random signs. Signs keep the blocks' size, which only these few blocks
    tell: so the quantile of the draws is taken for that of a normal variable, and returned as Student's.
    """
    rng = np.random.default_rng(0)
    parts = np.stack([s.block_parts for s in scores])
    prior = np.array([s.prior_part for s in scores])[:, None]
    drawn = parts @ rng.choice([-1.0, 1.0], (parts.shape[1], DRAWS)) + prior * rng.normal(size=(len(scores), DRAWS))
    normal = float(np.quantile(np.abs(drawn).max(axis=0), 1 - FALSE_ALARM_RATE))
    return float(student.isf(norm.sf(normal), max(parts.shape[1] - 1, 1)))
