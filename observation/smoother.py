"""The joints of a record afterwards: each row by the rows after it as well (Rauch, Tung and Striebel 1965).

The filter runs once and is remembered now and then; from the end on, each stretch is run again and smoothed, so that memory does
not grow with the record.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from observation.observer import FilteredRow, Observed, Observer

Array = NDArray[np.float64]

STRETCH = 500
"""rows that are kept at once"""


def smoothed(observer: Observer, count: int, step: Callable[[int], object]) -> list[Observed]:
    """The joints at `count` rows, in their order. step(row) makes the observer, which is at its beginning, take a row."""
    kept = []
    for row in range(count):
        if row % STRETCH == 0:
            kept.append(observer.snapshot())
        step(row)
    out: list[Observed] = []
    later: FilteredRow | None = None
    state, covariance = observer.state, observer.covariance
    for begin in range((count - 1) // STRETCH * STRETCH, -1, -STRETCH):
        observer.restore(kept[begin // STRETCH])
        rows = []
        for row in range(begin, min(begin + STRETCH, count)):
            step(row)
            rows.append(observer.last_row)
        for own in reversed(rows):
            if later is None or later.transition is None:
                state, covariance = own.state, own.covariance
            else:
                state, covariance = _corrected(later, state, covariance)
            out.append(observer.observed_of(state, covariance, own.motion))
            later = own
    return out[::-1]


def _corrected(later: FilteredRow, state: Array, covariance: Array) -> tuple[Array, Array]:
    """State (size,) and covariance (size, size) of the row before `later`, smoothed by those of `later`, smoothed already.

    The covariance is a sum of products with their own transpose: no rounding leaves a variance below zero."""
    assert later.transition is not None
    F, P = later.transition, later.origin_covariance
    sigma = np.sqrt(np.maximum(np.diag(later.predicted_covariance), 1e-300))
    scaled = later.predicted_covariance / np.outer(sigma, sigma)
    crossed = (P @ F.T) / sigma
    gain = np.linalg.solve(scaled + 1e-12 * np.eye(len(sigma)), crossed.T).T / sigma
    kept = np.eye(len(state)) - gain @ F
    noise = later.predicted_covariance - F @ P @ F.T
    smoothed_covariance = kept @ P @ kept.T + gain @ (covariance + noise) @ gain.T
    return later.origin + gain @ (state - later.predicted), (smoothed_covariance + smoothed_covariance.T) / 2
