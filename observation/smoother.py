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
                state, covariance = _corrected(own, later, state, covariance)
            out.append(observer.observed_of(state, covariance))
            later = own
    return out[::-1]


def _corrected(own: FilteredRow, later: FilteredRow, state: Array, covariance: Array) -> tuple[Array, Array]:
    """State (size,) and covariance (size, size) of a row, smoothed by those of the next, which are smoothed already."""
    assert later.transition is not None
    sigma = np.sqrt(np.maximum(np.diag(later.predicted_covariance), 1e-300))
    scaled = later.predicted_covariance / np.outer(sigma, sigma)
    crossed = (own.covariance @ later.transition.T) / sigma
    gain = np.linalg.solve(scaled + 1e-12 * np.eye(len(sigma)), crossed.T).T / sigma
    smoothed_covariance = own.covariance + gain @ (covariance - later.predicted_covariance) @ gain.T
    return own.state + gain @ (state - later.predicted), (smoothed_covariance + smoothed_covariance.T) / 2
