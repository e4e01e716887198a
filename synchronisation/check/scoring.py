"""How much each fault would explain of what healthy cables leave, and how much noise would explain as well.

Rows are whitened with the full covariance of each frame: vision's noise through Z, which all cables share, and each cable's own
error, found along. The law's factors are projected out under their priors. What correlation in time is left enters through blocks.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm
from scipy.stats import t as student

from mechanism.cable_lengths import Z
from synchronisation.check.elongation_law import SPREAD
from synchronisation.check.faults import FAULTS
from synchronisation.check.observation import Observed
from synchronisation.check.signatures import FaultCandidate

Array = NDArray[np.float64]

FIRST_ERROR_M, LEAST_ERROR_M = 2e-5, 3e-6
ROUNDS, STEPS = 3, 15
"""fits of the law, and steps of each cable's own error after each"""
WAVES, WAVE_M = 8, 5e-6
"""half waves over the recording, and m of each, that a healthy cable may wander by slowly"""
BLOCK_S = 2.0
"""s within which what is left may be correlated"""
BLIND = 1e-7
"""share of a signature's information below which the law, or a fault fitted along, has taken it up"""
FALSE_ALARMS, DRAWS = 0.005, 2000


@dataclass(frozen=True)
class Known:
    """Factors of the law (M P,) as believed before, with their covariance."""

    beta: Array
    covariance: Array


@dataclass(frozen=True)
class Fitted:
    """The law's fit: whitened nuisances A (F M, p) and rows, the normal matrix with priors, and what is left."""

    whiten: Array
    """(F, M, M): lower triangular, rows of one frame to unit variance"""
    A: Array
    prior: Array
    """(p, p), precision"""
    inverse: Array
    """of the normal matrix, (p, p)"""
    beta: Array
    left: Array
    """whitened residual, (F M,)"""
    error: Array
    """each cable's own error, (M,), m"""
    blocks: NDArray[np.intp]
    """of each row, where blocks begin"""
    residual: Array
    """(F, M), m"""
    with_baseline: bool

    def whitened(self, signature: Array) -> Array:
        """(F, M) -> (F M,)"""
        return np.einsum("tjk,tk->tj", self.whiten, signature).ravel()


@dataclass(frozen=True)
class Score:
    """One candidate: estimated size, its sigma, what it gains of chi-square, and its part in every block."""

    candidate: FaultCandidate
    size: float
    sigma: float
    gain: float
    parts: Array
    """what every block adds to the size, over sigma, (B,)"""
    prior: float
    """sigma's part that comes from priors, over sigma"""
    tolerance: float
    """size up to which an arm counts as healthy"""

    @property
    def z(self) -> float:
        """By how many sigma the size exceeds what a healthy arm may have."""
        return max(abs(self.size) - self.tolerance, 0.0) / self.sigma


def fit_law(
    seen: Observed, known: Known | None = None, faults: Sequence[Array] = (), error: Array | None = None
) -> Fitted:
    """The law with its priors, or with a baseline's; signatures (F, M) of `faults` are fitted along, free.

    error: each cable's own, (M,), m, where it is known already.
    """
    F, M = seen.x.shape
    P = seen.law.X.shape[2]
    columns = [np.eye(M)[j] * seen.law.X[:, j, p][:, None] for j in range(M) for p in range(P)]
    mean, precision = np.zeros(M * P), np.diag(np.tile(SPREAD**-2.0, M))
    if known is not None:
        mean, precision = known.beta, np.linalg.inv(known.covariance)
    spare: list[tuple[Array, float]] = [(s, 0.0) for s in faults]
    pull = -Z(seen.arm, seen.alpha)
    spare += [(pull[:, i], 1 / seen.common[i] ** 2) for i in range(seen.arm.N) if seen.common[i] > 0]
    if seen.clock_sigma > 0:
        spare.append((seen.theta_d * seen.arm.drum, seen.clock_sigma**-2.0))
    phase = np.pi * (seen.time - seen.time[0])[:, None] / np.ptp(seen.time)
    spare += [(np.cos(k * phase) * own, WAVE_M**-2.0) for k in range(1, WAVES + 1) for own in np.eye(M)]
    D = np.stack([*columns, *(s for s, _ in spare)], axis=-1)
    prior = np.zeros((D.shape[-1],) * 2)
    prior[: M * P, : M * P] = precision
    prior[range(M * P, len(prior)), range(M * P, len(prior))] = [p for _, p in spare]
    before = np.concatenate([mean, np.zeros(len(spare))])
    vision = seen.vision
    rounds = ROUNDS if error is None else 0
    error = np.full(M, FIRST_ERROR_M) if error is None else error
    u, whiten, A, inverse, beta = _solved(seen.x, vision, error, D, prior, before)
    for _ in range(rounds):
        error = _own_error(vision, seen.x - D @ beta, error)
        u, whiten, A, inverse, beta = _solved(seen.x, vision, error, D, prior, before)
    starts = np.searchsorted(seen.time, np.arange(seen.time[0], seen.time[-1], BLOCK_S)) * M
    blocks = np.unique(starts[starts < F * M])
    return Fitted(whiten, A, prior, inverse, beta, u - A @ beta, error, blocks, seen.x - D @ beta, known is not None)


def _solved(
    x: Array, vision: Array, error: Array, D: Array, prior: Array, before: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Whitened elongations, what whitens, whitened D, inverse normal matrix and factors."""
    whiten = np.asarray(np.linalg.inv(np.linalg.cholesky(vision + np.diag(error**2))), dtype=float)
    A = (whiten @ D).reshape(x.size, -1)
    u = np.einsum("tjk,tk->tj", whiten, x).ravel()
    inverse = np.asarray(np.linalg.inv(A.T @ A + prior), dtype=float)
    return u, whiten, A, inverse, inverse @ (A.T @ u + prior @ before)


def score(fit: Fitted, candidate: FaultCandidate) -> Score:
    """How much a candidate, alone, would explain of what the law leaves."""
    s = fit.whitened(candidate.signature)
    q = fit.inverse @ (fit.A.T @ s)
    free = s - fit.A @ q
    information = float(s @ free)
    if information <= BLIND * float(s @ s):
        nothing = np.zeros(len(fit.blocks))
        return Score(candidate, 0.0, np.inf, 0.0, nothing, 0.0, 0.0)
    size = float(s @ fit.left) / information
    # what is left when this fault is there tells how much correlated noise moves its size
    parts = np.add.reduceat(free * (fit.left - size * free), fit.blocks)
    believed = float(q @ fit.prior @ q)
    variance = max(float(parts @ parts) + believed, information)
    spread = np.sqrt(variance)
    fault = FAULTS[candidate.fault]
    return Score(
        candidate,
        size,
        float(spread) / information,
        size**2 * information,
        parts / spread,
        float(np.sqrt(believed / variance)),
        fault.tolerance_with_baseline if fit.with_baseline else fault.tolerance,
    )


def threshold(scores: Sequence[Score]) -> float:
    """The largest z that a healthy arm shows in FALSE_ALARMS of recordings: blocks of what this one leaves, with signs drawn.

    Signs keep the blocks' size, which is known from these few blocks only: what is drawn counts as normal, a z as Student's.
    """
    rng = np.random.default_rng(0)
    parts = np.stack([s.parts for s in scores])
    prior = np.array([s.prior for s in scores])[:, None]
    drawn = parts @ rng.choice([-1.0, 1.0], (parts.shape[1], DRAWS)) + prior * rng.normal(size=(len(scores), DRAWS))
    normal = float(np.quantile(np.abs(drawn).max(axis=0), 1 - FALSE_ALARMS))
    return float(student.isf(norm.sf(normal), max(parts.shape[1] - 1, 1)))


def _own_error(vision: Array, residual: Array, error: Array) -> Array:
    """Each cable's own error by expectation and maximisation, given what is left and vision's share of it."""
    for _ in range(STEPS):
        gain = error[:, None] ** 2 * np.linalg.inv(vision + np.diag(error**2))
        own = np.einsum("tjk,tk->tj", gain, residual)
        left = error**2 - np.einsum("tjj,j->tj", gain, error**2)
        error = np.maximum(np.sqrt(np.mean(own**2 + left, axis=0)), LEAST_ERROR_M)
    return error
