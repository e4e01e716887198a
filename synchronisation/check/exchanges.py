"""Exchanged signs and labels: the exchange of cables, of markers or of a motor's sign without which the elongations make no sense.

`sync` refuses such recordings by name; a data set made by hand reaches the check with them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from mechanism.cable_lengths import lengths
from state_estimation.elongation_law import left_by
from synchronisation.check.observation import ElongationObservation
from synchronisation.swapped_order import swapped_order

Array = NDArray[np.float64]

MIN_RESIDUAL_M = 3e-4
"""m, RMS of what the law leaves of the elongations, from which on exchanges are tried (docs/thresholds.md)"""
MAX_REMAINING_SHARE = 0.25
"""an exchange is named if undoing it leaves at most this share of that residual (docs/thresholds.md)"""


@dataclass(frozen=True)
class Exchange:
    """An exchange, where it is, and the RMS residual of all elongations, m, with and without undoing it."""

    fault: str
    where: str
    rms_undone: float
    rms_described: float


def find_exchange(observation: ElongationObservation) -> Exchange | None:
    """The exchange that leaves least when undone; None where none is needed or none helps."""
    described = _residual_rms(observation, observation.alpha, observation.theta, observation.law.X)
    if described < MIN_RESIDUAL_M:
        return None
    exchanges = [
        Exchange(*place, _residual_rms(observation, *series), described) for place, *series in _hypotheses(observation)
    ]
    best = min(exchanges, key=lambda e: e.rms_undone)
    return best if best.rms_undone < MAX_REMAINING_SHARE * described else None


def _hypotheses(observation: ElongationObservation) -> Iterator[tuple[tuple[str, str], Array, Array, Array]]:
    """Fault and place of each exchange, and alpha, theta and regressors with it undone."""
    alpha, theta, X = observation.alpha, observation.theta, observation.law.X
    n, m = observation.arm.N, observation.arm.M
    for j in range(m):
        yield ("theta_sign", f"cable {j + 1}"), alpha, theta * np.where(np.arange(m) == j, -1.0, 1.0), X
    yield ("theta_sign", "all"), alpha, -theta, X
    for pair in combinations(range(m), 2):
        order = swapped_order(m, *pair)
        where = f"cables {pair[0] + 1} and {pair[1] + 1}"
        yield ("swapped_cables", where), alpha, theta[:, order], X[:, order]
        # only the columns of theta, not those of f
        yield ("swapped_cables", where), alpha, theta[:, order], X
    for pair in combinations(range(n), 2):
        where = f"mechanisms {pair[0] + 1} and {pair[1] + 1}"
        yield ("swapped_markers", where), alpha[:, swapped_order(n, *pair)], theta, X
    # markers of bars 0..N: their angles against the base's
    gamma = np.concatenate([np.zeros((len(alpha), 1)), np.cumsum(alpha, axis=1)], axis=1)
    for pair in combinations(range(n + 1), 2):
        other = np.diff(gamma[:, swapped_order(n + 1, *pair)], axis=1)
        yield ("swapped_markers", f"bars {pair[0]} and {pair[1]}"), other, theta, X


def _residual_rms(observation: ElongationObservation, alpha: Array, theta: Array, X: Array) -> float:
    """RMS, m, of what the regressors X (F, M, P) leave of all elongations."""
    arm = observation.arm
    with np.errstate(invalid="ignore"):
        x = lengths(arm, alpha) + arm.drum * theta
    if not np.isfinite(x).all():
        return np.inf
    return float(np.sqrt(np.mean(left_by(X, x) ** 2)))
