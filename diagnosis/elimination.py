"""The base model's numbers and the nuisances eliminated: what is left is a small system in causes and effects alone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from diagnosis.comparison import RIDGE, Comparison, with_unit_diagonal

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Eliminated:
    """x G x / 2 - b x of the columns behind the nuisances, where all before them is at its best; loss where x is zero."""

    first: int
    """number of the first of these columns"""
    G: Array
    b: Array
    loss: float


def eliminated(comparison: Comparison) -> Eliminated:
    """What any choice of causes and effects would leave, none of which the residual holds yet."""
    c = comparison
    first, last = c.base_count + c.nuisance_count, len(c.prior_sigma)
    sigma = c.sigma()
    G = c.products[:last, :last] + np.diag(1 / sigma**2)
    prior = c.prior_mean / sigma**2
    b = prior - c.products[:last, last]
    total = float(c.products[last, last] + prior @ c.prior_mean)
    G, scale = with_unit_diagonal(G)
    G, b = G + RIDGE * np.eye(last), b / scale
    factor = cho_factor(G[:first, :first])
    across = cho_solve(factor, G[:first, first:])
    S = G[first:, first:] - G[:first, first:].T @ across
    reduced = b[first:] - across.T @ b[:first]
    back = scale[first:]
    return Eliminated(
        first=first,
        G=S * np.outer(back, back),
        b=reduced * back,
        loss=total - float(b[:first] @ cho_solve(factor, b[:first])),
    )
