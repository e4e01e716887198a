"""Signs and labels: the exchange of cables, markers or a motor's sign without which the elongations make no sense.

`sync` refuses such recordings by name; a data set made by hand reaches the check with them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from mechanism.cable_lengths import lengths
from synchronisation.check.observation import Observed

Array = NDArray[np.float64]

SUSPICIOUS_M = 3e-4
"""what the law may leave of an elongation, RMS, before exchanges are tried"""
EXPLAINS = 0.25
"""an exchange leaves at most this share of what is left without it"""


@dataclass(frozen=True)
class Exchange:
    """What is exchanged, where, and what the law leaves of all elongations with and without undoing it, RMS, m."""

    fault: str
    where: str
    undone: float
    described: float


def find_exchange(seen: Observed) -> Exchange | None:
    """The exchange that leaves least, None where there is no need for one or none helps."""
    described = _left(seen, seen.alpha, seen.theta, seen.law.X)
    if described < SUSPICIOUS_M:
        return None
    tried = [Exchange(*place, _left(seen, *series), described) for place, *series in _hypotheses(seen)]
    best = min(tried, key=lambda e: e.undone)
    return best if best.undone < EXPLAINS * described else None


def _hypotheses(seen: Observed) -> Iterator[tuple[tuple[str, str], Array, Array, Array]]:
    """The place in words, and alpha, theta and regressors as they would be."""
    alpha, theta, X = seen.alpha, seen.theta, seen.law.X
    n, m = seen.arm.N, seen.arm.M
    for j in range(m):
        yield ("theta_sign", f"cable {j + 1}"), alpha, theta * np.where(np.arange(m) == j, -1.0, 1.0), X
    yield ("theta_sign", "all"), alpha, -theta, X
    for pair in combinations(range(m), 2):
        order = _swapped(m, *pair)
        where = f"cables {pair[0] + 1} and {pair[1] + 1}"
        yield ("swapped_cables", where), alpha, theta[:, order], X[:, order]
        # only the columns of theta, not those of f
        yield ("swapped_cables", where), alpha, theta[:, order], X
    for pair in combinations(range(n), 2):
        where = f"mechanisms {pair[0] + 1} and {pair[1] + 1}"
        yield ("swapped_markers", where), alpha[:, _swapped(n, *pair)], theta, X
    # markers of bars 0..N: their angles against the base's
    gamma = np.concatenate([np.zeros((len(alpha), 1)), np.cumsum(alpha, axis=1)], axis=1)
    for pair in combinations(range(n + 1), 2):
        other = np.diff(gamma[:, _swapped(n + 1, *pair)], axis=1)
        yield ("swapped_markers", f"bars {pair[0]} and {pair[1]}"), other, theta, X


def _swapped(count: int, a: int, b: int) -> list[int]:
    order = list(range(count))
    order[a], order[b] = b, a
    return order


def _left(seen: Observed, alpha: Array, theta: Array, X: Array) -> float:
    """RMS of all elongations that the regressors leave, m."""
    arm = seen.arm
    with np.errstate(invalid="ignore"):
        x = lengths(arm, alpha) + arm.drum * theta
    if not np.isfinite(x).all():
        return np.inf
    left = [x[:, j] - X[:, j] @ np.linalg.lstsq(X[:, j], x[:, j], rcond=None)[0] for j in range(arm.M)]
    return float(np.sqrt(np.mean(np.square(left))))
