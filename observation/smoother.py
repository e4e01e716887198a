"""The joints of a record afterwards: each row by the rows after it as well (Rauch, Tung and Striebel 1965).

The filter runs once and is remembered now and then; from the end on, each stretch is run again and smoothed, so that memory does
not grow with the record.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from observation.observer import Observed, Observer

Array = NDArray[np.float64]

STRETCH = 500
"""rows that are kept at once"""


@dataclass(frozen=True)
class _Row:
    """Of one row: the filter's state, and the prediction that led to it."""

    transition: Array | None
    """None where the observer began"""
    predicted: Array
    predicted_covariance: Array
    state: Array
    covariance: Array


def smoothed(observer: Observer, count: int, step: Callable[[int], object]) -> list[Observed]:
    """Of all rows. step(row) makes the observer, which is at its beginning, take a row."""
    kept = []
    for row in range(count):
        if row % STRETCH == 0:
            kept.append(copy.deepcopy(observer.memory))
        step(row)
    out: list[Observed] = []
    later: _Row | None = None
    state, covariance = observer.state, observer.covariance
    for begin in range((count - 1) // STRETCH * STRETCH, -1, -STRETCH):
        observer.memory = copy.deepcopy(kept[begin // STRETCH])
        rows = []
        for row in range(begin, min(begin + STRETCH, count)):
            step(row)
            rows.append(
                _Row(
                    observer.transition,
                    observer.predicted,
                    observer.predicted_covariance,
                    observer.state,
                    observer.covariance,
                )
            )
        for own in reversed(rows):
            if later is None or later.transition is None:
                state, covariance = own.state, own.covariance
            else:
                state, covariance = _corrected(own, later, state, covariance)
            out.append(observer.observed_of(state, covariance))
            later = own
    return out[::-1]


def _corrected(own: _Row, later: _Row, state: Array, covariance: Array) -> tuple[Array, Array]:
    """A row's estimate by the smoothed estimate of the next."""
    assert later.transition is not None
    sigma = np.sqrt(np.maximum(np.diag(later.predicted_covariance), 1e-300))
    scaled = later.predicted_covariance / np.outer(sigma, sigma)
    crossed = (own.covariance @ later.transition.T) / sigma
    gain = np.linalg.solve(scaled + 1e-12 * np.eye(len(sigma)), crossed.T).T / sigma
    smoothed_covariance = own.covariance + gain @ (covariance - later.predicted_covariance) @ gain.T
    return own.state + gain @ (state - later.predicted), (smoothed_covariance + smoothed_covariance.T) / 2
