"""Laws fitted to recordings: least squares first, then instrumental variables, with a covariance that holds for correlated errors.

least squares   sum over channels and rows of (whitened residual)^2, by Gauss-Newton within the bounds of the terms
instruments     Zi^T residual = 0, Zi the columns that follow from the motors alone (instruments.py)
covariance      by a jackknife over blocks of a second, with what errors that a whole recording shares add to it
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from identification.block_covariance import (
    BLOCK_S,
    MIN_BLOCKS,
    BlockSums,
    block_sums,
    jackknife_influence,
    shared_error_residuals,
    student_inflated,
)
from identification.instruments import instrument_signals, remembering_by_motors
from identification.residuals import ResidualRows, residual_rows
from identification.signals import Signals
from identification.unknowns import Unknowns
from identification.whitening import WHITENING_ORDER, Whitener, fit_whitener

Array = NDArray[np.float64]

_MAX_ITERATIONS, _INSTRUMENT_ITERATIONS = 5, 2
_TOLERANCE = 0.02
"""sizes of a term: a smaller step ends the iteration; the next one, with another whitening, starts from there"""
_MAX_LED_TO_BOUNDS = 0.2
"""of the numbers that least squares has within their ranges: more at their ends is no estimate. The loss does not tell: least
squares has the least whatever noise it takes for motion (docs/thresholds.md)"""
_MAX_LOSS_RATIO = 2.0
"""times the loss of least squares, beyond which instruments that led astray do so with least squares' help too
(docs/thresholds.md)"""
_WEAK_INSTRUMENT = 0.1
"""cosine between a combination of instruments and what they stand for, below which, of those that led astray, they are none
(docs/thresholds.md)"""
_MAX_STEP = 2000.0
"""sizes of a term: bound of one step, far beyond what is much on a usual arm; also a prior of that width, so that what nothing
determines stays"""
_MIN_EIGENVALUE = 1e-9
"""of the information with its diagonal scaled to one: below it a combination of parameters is unobserved (docs/thresholds.md)"""
MAX_UNOBSERVED_SHARE = 0.01
"""share of a parameter that lies in unobserved combinations, above which it is not determined at all (docs/thresholds.md)"""
_BOUND_MARGIN = 1e-6
"""share of a term's range within which a value counts as at its bound (docs/thresholds.md)"""


@dataclass(frozen=True)
class FitSolution:
    """Parameters (P,) with covariance (P, P) by instrumental variables and by least squares, and how far to trust them."""

    p: Array
    covariance: Array
    least_squares: Array
    least_squares_covariance: Array
    difference_covariance: Array
    """covariance of the instruments' parameters less those of least squares, if neither were biased, (P, P)"""
    blocks: int
    """number of blocks of the jackknife"""
    information: Array
    """J^T J of whitened rows at p, with the priors', (P, P)"""
    residuals: tuple[Array, ...]
    """residuals (C, S) of each recording, not whitened"""
    at_bound: NDArray[np.bool_]
    """parameters at a bound of their term, (P,)"""
    instrumented: NDArray[np.bool_]
    """parameters whose column the instruments replace, (P,)"""

    @property
    def is_least_squares(self) -> bool:
        """Whether instruments led astray, so that least squares' parameters stayed."""
        return bool(np.array_equal(self.p, self.least_squares))


class _Prior:
    """Gaussian priors of some parameters, as further rows of the fit."""

    def __init__(self, u: Unknowns, priors: Mapping[int, tuple[float, float]]) -> None:
        self.mean = np.zeros(len(u.entries))
        self.weight = np.zeros(len(u.entries))
        for place, (mean, sigma) in priors.items():
            self.mean[place], self.weight[place] = mean, 1 / sigma
        self.information = np.diag(self.weight**2)
        self.roots = np.diag(self.weight)[self.weight > 0]

    def gradient(self, p: Array) -> Array:
        """Gradient at p, (P,)."""
        return self.weight**2 * (p - self.mean)


@dataclass(frozen=True)
class _Problem:
    """What is fitted to what."""

    recordings: Sequence[Signals]
    unknowns: Unknowns
    prior: _Prior
    starts: Sequence[NDArray[np.bool_]]
    """first rows of the segments of each recording, (S,)"""

    def recordings_at(self, p: Array) -> list[Signals]:
        """The recordings, their cables remembering by the laws at p."""
        return [remembering_by_motors(s, self.unknowns, p, r) for r, s in enumerate(self.recordings)]

    def rows(self, p: Array, recordings: Sequence[Signals] | None = None) -> list[ResidualRows]:
        """Residuals and derivatives of every recording at p; recordings: in the place of those of `recordings_at`, or the same."""
        recordings = recordings or self.recordings_at(p)
        return [residual_rows(s, self.unknowns, p, r) for r, s in enumerate(recordings)]

    def whitened(self, whiten: Whitener, values: Sequence[Array]) -> list[Array]:
        """Values (C, S, ...) of every recording, whitened."""
        return [whiten(v, starts) for v, starts in zip(values, self.starts, strict=True)]


def fit_by_least_squares(
    recordings: Sequence[Signals],
    u: Unknowns,
    priors: Mapping[int, tuple[float, float]] | None = None,
    start: Array | None = None,
) -> Array:
    """The first stage of the fit alone: parameters (P,). Arguments as those of `fit_laws`."""
    return _least_squares(_problem(recordings, u, priors), u.start() if start is None else start)[0]


def fit_laws(
    recordings: Sequence[Signals],
    u: Unknowns,
    priors: Mapping[int, tuple[float, float]] | None = None,
    start: Array | None = None,
    noise: Sequence[Array] | None = None,
) -> FitSolution:
    """Both stages of the fit. priors: mean and sigma by place in the parameter vector; start: parameters (P,) near the solution.

    noise: of each recording, (C, S), what its rows err by, where the fit's own residuals hold more than that.
    """
    problem = _problem(recordings, u, priors)
    first, whiten = _least_squares(problem, u.start() if start is None else start, noise)
    at_first = problem.recordings_at(first)
    rows = problem.rows(first, at_first)
    motors = [instrument_signals(s, u, first, r) for r, s in enumerate(at_first)]
    instruments = [f.jacobian for f in problem.rows(first, motors)]
    instrumented = np.any(
        [np.abs(i - f.jacobian).max(axis=(0, 1)) > 0 for i, f in zip(instruments, rows, strict=True)], axis=0
    )
    Zi = problem.whitened(whiten, instruments)
    free = ~_at_bound(u, first)
    p = _instrument_estimate(problem, whiten, Zi, first, free)
    if np.mean(_at_bound(u, p)[free]) > _MAX_LED_TO_BOUNDS:  # what instruments hardly follow leads anywhere
        Zi = _strengthened(Zi, problem.whitened(whiten, [f.jacobian for f in rows]), free)
        p = _instrument_estimate(problem, whiten, Zi, first, free)
        if _loss(problem, whiten, p) > _MAX_LOSS_RATIO * _loss(problem, whiten, first):
            p, instrumented = first, np.zeros_like(instrumented)
    at_p = problem.recordings_at(p)
    rows = problem.rows(p, at_p)
    J = problem.whitened(whiten, [f.jacobian for f in rows])
    e = problem.whitened(whiten, noise or [f.residual for f in rows])
    shared = problem.whitened(whiten, [shared_error_residuals(s, u, p, r) for r, s in enumerate(at_p)])
    by_instruments, by_least_squares = (_influences(problem, columns, J, e, shared, free) for columns in (Zi, J))
    difference = np.concatenate(by_instruments[:2]) - np.concatenate(by_least_squares[:2])
    information = np.asarray(sum(np.einsum("csp,csq->pq", j, j) for j in J)) + problem.prior.information
    unobserved = np.diag(unobserved_projection(information, free)) > MAX_UNOBSERVED_SHARE
    covariance = _covariance(*by_instruments)
    covariance[unobserved, unobserved] = np.inf
    return FitSolution(
        p=p,
        covariance=covariance,
        least_squares=first,
        least_squares_covariance=_covariance(*by_least_squares),
        difference_covariance=difference.T @ difference,
        blocks=len(by_instruments[0]),
        information=information,
        residuals=tuple(f.residual for f in rows),
        at_bound=_at_bound(u, p),
        instrumented=instrumented,
    )


def _problem(recordings: Sequence[Signals], u: Unknowns, priors: Mapping[int, tuple[float, float]] | None) -> _Problem:
    known = u.start_priors | dict(priors or {})
    return _Problem(recordings, u, _Prior(u, known), [segment_starts(s) for s in recordings])


def _least_squares(problem: _Problem, start: Array, noise: Sequence[Array] | None = None) -> tuple[Array, Whitener]:
    """Parameters, and the whitener of their residuals; first with channels weighted by size alone, then with rows whitened."""
    p, whiten = start, Whitener(np.ones((0, 1)))
    for order in (0, WHITENING_ORDER):
        for _ in range(_MAX_ITERATIONS):
            rows = problem.rows(p)
            whiten = fit_whitener(list(noise or [r.residual for r in rows]), list(problem.starts), order)
            before, p = p, _gauss_newton_step(problem, whiten, rows, p)
            if np.max(np.abs(p - before) / problem.unknowns.size) < _TOLERANCE:
                break
    return p, whiten


def _gauss_newton_step(problem: _Problem, whiten: Whitener, rows: list[ResidualRows], p: Array) -> Array:
    """The parameters after one step within the bounds."""
    u, prior = problem.unknowns, problem.prior
    pieces = []
    for f, starts in zip(rows, problem.starts, strict=True):
        J = whiten(f.jacobian, starts).reshape(-1, len(p)) * u.size
        e = whiten(f.residual, starts).reshape(-1, 1)
        pieces.append(np.linalg.qr(np.concatenate([J, e], axis=1), mode="r"))
    prior_rows = np.concatenate([np.diag(prior.weight * u.size), (prior.weight * (p - prior.mean))[:, None]], axis=1)
    damping = np.eye(len(p), len(p) + 1) / _MAX_STEP
    R = np.asarray(np.linalg.qr(np.concatenate([*pieces, prior_rows, damping]), mode="r"))
    # a start may lie beyond the bounds, as a cause's amount that chance took below nothing does
    low, high = (np.clip((end - p) / u.size, -_MAX_STEP, _MAX_STEP) for end in (u.low, u.high))
    step = lsq_linear(R[:, :-1], -R[:, -1], (low - 1e-12, high + 1e-12))
    return np.clip(p + u.size * step.x, u.low, u.high)


def _instrument_estimate(
    problem: _Problem, whiten: Whitener, Zi: list[Array], p: Array, free: NDArray[np.bool_]
) -> Array:
    """Parameters at which the whitened instruments Zi (C, S, P) are orthogonal to the residuals, from p on."""
    u, prior = problem.unknowns, problem.prior
    for _ in range(_INSTRUMENT_ITERATIONS):
        rows = problem.rows(p)
        parts = list(zip(Zi, rows, problem.starts, strict=True))
        A = sum(np.einsum("csp,csq->pq", z, whiten(f.jacobian, starts)) for z, f, starts in parts)
        g = sum(np.einsum("csp,cs->p", z, whiten(f.residual, starts)) for z, f, starts in parts)
        A, g = A + prior.information, g + prior.gradient(p)
        p = np.clip(p - _inverse(A, free, u.size) @ g, u.low, u.high)
    return p


def _strengthened(Z: list[Array], J: list[Array], free: NDArray[np.bool_]) -> list[Array]:
    """Instruments with the Jacobian in the place of those combinations that hardly follow it; both whitened, (C, S, P) each.

    Least squares decides these, as it does without instruments; all others keep theirs."""
    squares, products = (sum(np.einsum("csp,csq->pq", a, j) for a, j in zip(by, J, strict=True)) for by in (J, Z))
    squares, products = (np.asarray(a)[np.ix_(free, free)] for a in (squares, products))
    scale = np.sqrt(np.maximum(np.diag(squares), np.finfo(float).tiny))
    size, vectors = np.linalg.eigh(squares / np.outer(scale, scale))
    kept = size > _MIN_EIGENVALUE * size[-1]
    root = vectors[:, kept] / np.sqrt(size[kept]) / scale[:, None]
    left, follows, right = np.linalg.svd(root.T @ products @ root)
    weak = follows < _WEAK_INSTRUMENT
    # combinations in terms of what each column counts in the others
    back = scale[:, None] * vectors[:, kept] * np.sqrt(size[kept])
    by_others = root @ left[:, weak] @ (back @ left[:, weak]).T
    by_jacobian = root @ right[weak].T @ (back @ left[:, weak]).T
    out = []
    for z, j in zip(Z, J, strict=True):
        stronger = z.copy()
        stronger[..., free] += j[..., free] @ by_jacobian - z[..., free] @ by_others
        out.append(stronger)
    return out


def _loss(problem: _Problem, whiten: Whitener, p: Array) -> float:
    """Sum of the squares of whitened residuals at p."""
    return float(sum(np.sum(r**2) for r in problem.whitened(whiten, [f.residual for f in problem.rows(p)])))


def _influences(
    problem: _Problem, Z: list[Array], J: list[Array], e: list[Array], shared: list[Array], free: NDArray[np.bool_]
) -> tuple[Array, Array, Array]:
    """What each block, each prior and each shared error adds to the parameters: (B, P), (K, P), (E, P).

    Of a memory with which a recording begins, K has what white residuals leave of it.

    Of each recording, all whitened: instruments Z and Jacobian J (C, S, P), residuals e (C, S), shared errors (C, S, E).
    """
    first, size = problem.recordings[0], problem.unknowns.size
    seconds = sum(s.step * s.low_pass.factor * len(s.low_pass.kept) for s in problem.recordings)
    rate = 1 / (first.step * first.low_pass.factor)
    length = max(1, round(min(BLOCK_S, seconds / MIN_BLOCKS) * rate))
    sums = [block_sums(z, r, j, length) for z, r, j in zip(Z, e, J, strict=True)]
    blocks = BlockSums(np.concatenate([b.gradient for b in sums]), np.concatenate([b.slope for b in sums]))
    A = blocks.slope.sum(axis=0) + problem.prior.information
    inverse = _inverse(A, free, size)
    of_shared = [np.einsum("csp,cse->ep", z, c) for z, c in zip(Z, shared, strict=True)]
    # the first block alone tells with what memory a recording begins: without it nothing would
    starts = np.isin(np.arange(len(size)), list(problem.unknowns.start_priors))
    of_starts = np.diag(np.sqrt(np.abs(np.diag(inverse))))[starts & free]
    return (
        jackknife_influence(blocks, A, free & ~starts, size),
        np.concatenate([problem.prior.roots @ inverse.T, of_starts]),
        np.concatenate(of_shared) @ inverse.T,
    )


def _covariance(blocks: Array, priors: Array, shared: Array) -> Array:
    """Covariance by all influences, (P, P)."""
    influences = np.concatenate([student_inflated(blocks), priors, shared])
    return influences.T @ influences


def unobserved_projection(information: Array, free: NDArray[np.bool_]) -> Array:
    """Projection onto the combinations of parameters, scaled to unit columns, that the rows do not determine, (P, P).

    Its diagonal is the share of each parameter that lies in them.
    """
    scale = np.sqrt(np.diag(information))
    place = np.flatnonzero(free & (scale > 0))
    values, vectors = np.linalg.eigh(information[np.ix_(place, place)] / np.outer(scale[place], scale[place]))
    unobserved = vectors[:, values < _MIN_EIGENVALUE]
    out = np.zeros_like(information)
    out[np.ix_(place, place)] = unobserved @ unobserved.T
    return out


def segment_starts(s: Signals) -> NDArray[np.bool_]:
    """Filtered rows that have none right before them, (S,)."""
    return s.low_pass.starts


def _at_bound(u: Unknowns, p: Array) -> NDArray[np.bool_]:
    range_of = u.high - u.low
    margin = np.where(np.isfinite(range_of), _BOUND_MARGIN * range_of, 0.0)  # what has no end is at none
    return (p <= u.low + margin) | (p >= u.high - margin)


def _inverse(A: Array, free: NDArray[np.bool_], size: Array) -> Array:
    """Pseudo-inverse of the free part of A (P, P), zero elsewhere: directions that nothing determines stay."""
    out = np.zeros_like(A)
    chosen = np.ix_(free, free)
    scale = size[free]
    out[chosen] = np.linalg.pinv(A[chosen] * np.outer(scale, scale), rcond=1e-13) * np.outer(scale, scale)
    return out
