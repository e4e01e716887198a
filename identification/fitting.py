"""Laws fitted to recordings: least squares first, then instruments, with an uncertainty that holds.

least squares   sum over channels and rows of (whitened residual)^2, Gauss and Newton within the terms' bounds
instruments     Zi^T residual = 0, Zi the columns that the motors alone tell (instruments.py)
covariance      by leaving out blocks of a second in turn, and what errors that a recording shares do
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from identification.block_covariance import BLOCK_S, MIN_BLOCKS, BlockSums, block_sums, jackknife_influence, shared_error_residuals, student_inflated
from identification.instruments import instrument_signals
from identification.residuals import ResidualRows, residual_rows
from identification.signals import Signals
from identification.unknowns import Unknowns
from identification.whitening import WHITENING_ORDER, Whitener, fit_whitener

Array = NDArray[np.float64]

_ROUNDS, _DRIVEN_ROUNDS = 5, 2
_SETTLED = 0.02
"""of a term's size: a step that is smaller ends a round, and the next one starts from it"""
_REACH = 50.0
"""sizes of a term: one step goes no further, and where nothing is told not at all"""
_BLIND = 1e-9
"""of one, in columns scaled to one: what rows tell of a combination at least"""
MAX_UNOBSERVED_SHARE = 0.01
"""share of a parameter from which it is not told at all"""
_NEAR_BOUND = 1e-6
"""of a term's range"""


@dataclass(frozen=True)
class FitSolution:
    """Parameters (P,) with covariance (P, P), both ways, and what tells how far to trust them."""

    p: Array
    covariance: Array
    least_squares: Array
    least_squares_covariance: Array
    difference_covariance: Array
    """of instruments' less least squares' parameters, were neither biased"""
    blocks: int
    information: Array
    """J^T J of whitened rows at p, (P, P)"""
    residuals: tuple[Array, ...]
    """(C, S) of each recording, not whitened"""
    at_bound: NDArray[np.bool_]
    touched: NDArray[np.bool_]
    """terms whose column the instruments replace"""


def fit_laws(
    recordings: Sequence[Signals], u: Unknowns, priors: Mapping[int, tuple[float, float]] | None = None
) -> FitSolution:
    """Both stages. priors: mean and sigma by place in the vector."""
    prior = _Prior(u, priors or {})
    starts = [segment_starts(s) for s in recordings]
    p = u.start()

    def linearised(p: Array) -> list[ResidualRows]:
        return [residual_rows(s, u, p, r) for r, s in enumerate(recordings)]

    # first every channel by its size alone, until the numbers settle; then by what its rows tell beyond those before them
    whiten = Whitener(np.ones((0, 1)))
    for order in (0, WHITENING_ORDER):
        for _ in range(_ROUNDS):
            found = linearised(p)
            whiten = fit_whitener([r.residual for r in found], starts, order)
            before, p = p, _stepped(found, whiten, starts, u, prior, p)
            if np.max(np.abs(p - before) / u.size) < _SETTLED:
                break
    first, found = p, linearised(p)
    instruments = [residual_rows(instrument_signals(s, u, first, r), u, first, r).jacobian for r, s in enumerate(recordings)]
    touched = np.any(
        [np.abs(i - f.jacobian).max(axis=(0, 1)) > 0 for i, f in zip(instruments, found, strict=True)], axis=0
    )
    Zi = [whiten(i, b) for i, b in zip(instruments, starts, strict=True)]
    free = ~_at_bound(u, p)
    for _ in range(_DRIVEN_ROUNDS):
        A = sum(np.einsum("csp,csq->pq", z, whiten(f.jacobian, b)) for z, f, b in zip(Zi, found, starts, strict=True))
        g = sum(np.einsum("csp,cs->p", z, whiten(f.residual, b)) for z, f, b in zip(Zi, found, starts, strict=True))
        A, g = A + prior.information, g + prior.pull(p)
        p = np.clip(p - _solved(A, g, free, u.size), u.low, u.high)
        found = linearised(p)
    J = [whiten(f.jacobian, b) for f, b in zip(found, starts, strict=True)]
    e = [whiten(f.residual, b) for f, b in zip(found, starts, strict=True)]
    total = sum(s.step * s.low_pass.factor * len(s.low_pass.kept) for s in recordings)
    block_s = min(BLOCK_S, total / MIN_BLOCKS)
    rate = 1 / (recordings[0].step * recordings[0].low_pass.factor)

    length = max(1, round(block_s * rate))

    common = [whiten(shared_error_residuals(s, u, p, r), b) for r, (s, b) in enumerate(zip(recordings, starts, strict=True))]

    def spread(Z: list[Array]) -> tuple[Array, Array, Array]:
        """What each block, each prior and each shared error does to the parameters: (B, P), (K, P), (E, P)."""
        parts = [block_sums(z, r, j, length) for z, r, j in zip(Z, e, J, strict=True)]
        blocks = BlockSums(np.concatenate([b.pull for b in parts]), np.concatenate([b.slope for b in parts]))
        A = blocks.slope.sum(axis=0) + prior.information
        inverse = _inverse(A, free, u.size)
        shared = [np.einsum("csp,cse->ep", z, c) for z, c in zip(Z, common, strict=True)]
        return jackknife_influence(blocks, A, free, u.size), prior.roots @ inverse.T, np.concatenate(shared) @ inverse.T

    ours, plain = spread(Zi), spread(J)
    apart = np.concatenate(ours[:2]) - np.concatenate(plain[:2])
    information = np.asarray(sum(np.einsum("csp,csq->pq", j, j) for j in J)) + prior.information
    unseen = np.diag(unobserved_projection(information, free)) > MAX_UNOBSERVED_SHARE
    covariance = _summed(*ours)
    covariance[unseen, unseen] = np.inf
    return FitSolution(
        p=p,
        covariance=covariance,
        least_squares=first,
        least_squares_covariance=_summed(*plain),
        difference_covariance=apart.T @ apart,
        blocks=len(ours[0]),
        information=information,
        residuals=tuple(f.residual for f in found),
        at_bound=_at_bound(u, p),
        touched=touched,
    )


def _summed(blocks: Array, priors: Array, shared: Array) -> Array:
    """Covariance, (P, P)."""
    every = np.concatenate([student_inflated(blocks), priors, shared])
    return every.T @ every


def unobserved_projection(information: Array, free: NDArray[np.bool_]) -> Array:
    """Projection onto the combinations of parameters, scaled to columns of one, that the rows do not tell, (P, P).

    Its diagonal is what of each parameter is not told.
    """
    scale = np.sqrt(np.diag(information))
    place = np.flatnonzero(free & (scale > 0))
    values, vectors = np.linalg.eigh(information[np.ix_(place, place)] / np.outer(scale[place], scale[place]))
    nothing = vectors[:, values < _BLIND]
    out = np.zeros_like(information)
    out[np.ix_(place, place)] = nothing @ nothing.T
    return out


class _Prior:
    """Gaussian knowledge of some parameters, as further rows."""

    def __init__(self, u: Unknowns, known: Mapping[int, tuple[float, float]]) -> None:
        self.mean = np.zeros(len(u.entries))
        self.weight = np.zeros(len(u.entries))
        for place, (mean, sigma) in known.items():
            self.mean[place], self.weight[place] = mean, 1 / sigma
        self.information = np.diag(self.weight**2)
        self.roots = np.diag(self.weight)[self.weight > 0]

    def pull(self, p: Array) -> Array:
        """Gradient at p, (P,)."""
        return self.weight**2 * (p - self.mean)


def _stepped(
    found: list[ResidualRows], whiten: Whitener, starts: list[NDArray[np.bool_]], u: Unknowns, prior: _Prior, p: Array
) -> Array:
    """One step of Gauss and Newton within the bounds."""
    pieces = []
    for f, begin in zip(found, starts, strict=True):
        J = whiten(f.jacobian, begin).reshape(-1, len(p)) * u.size
        e = whiten(f.residual, begin).reshape(-1, 1)
        pieces.append(np.linalg.qr(np.concatenate([J, e], axis=1), mode="r"))
    knowledge = np.concatenate([np.diag(prior.weight * u.size), (prior.weight * (p - prior.mean))[:, None]], axis=1)
    damping = np.eye(len(p), len(p) + 1) / _REACH
    R = np.asarray(np.linalg.qr(np.concatenate([*pieces, knowledge, damping]), mode="r"))
    low, high = np.maximum((u.low - p) / u.size, -_REACH), np.minimum((u.high - p) / u.size, _REACH)
    step = lsq_linear(R[:, :-1], -R[:, -1], (low - 1e-12, high + 1e-12))
    return np.clip(p + u.size * step.x, u.low, u.high)


def segment_starts(s: Signals) -> NDArray[np.bool_]:
    """Filtered rows that have none right before them."""
    kept = s.low_pass.kept
    return np.concatenate([[True], np.diff(kept) > s.low_pass.factor])


def _at_bound(u: Unknowns, p: Array) -> NDArray[np.bool_]:
    margin = _NEAR_BOUND * (u.high - u.low)
    return (p <= u.low + margin) | (p >= u.high - margin)


def _solved(A: Array, g: Array, free: NDArray[np.bool_], size: Array) -> Array:
    return _inverse(A, free, size) @ g


def _inverse(A: Array, free: NDArray[np.bool_], size: Array) -> Array:
    """Of the free part, zero elsewhere; directions that nothing tells stay put."""
    out = np.zeros_like(A)
    chosen = np.ix_(free, free)
    scale = size[free]
    out[chosen] = np.linalg.pinv(A[chosen] * np.outer(scale, scale), rcond=1e-13) * np.outer(scale, scale)
    return out
