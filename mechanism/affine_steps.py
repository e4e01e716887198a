"""Steps z -> decay z + added along a recording, and sums that stay within bounds, without a loop over its rows."""

import numpy as np
from scipy.linalg.lapack import dtbtrs  # pyright: ignore[reportAttributeAccessIssue] (made when imported)

from mechanism.arm import Array


def accumulated(start: Array, decay: Array, added: Array) -> Array:
    """z[i + 1] = decay[i] z[i] + added[i] from a start on, (T + 1, ...).

    As equations in all rows at once, whose matrix is a diagonal of ones with the decays below it: solved from above."""
    steps, start = len(decay), np.broadcast_to(start, decay.shape[1:])
    below, right = np.ones((2, steps + 1), order="F"), np.empty((start.size, steps + 1))
    right[:, 0], right[:, 1:] = start.ravel(), added.reshape(steps, start.size).T
    for column, decays in zip(right, decay.reshape(steps, start.size).T, strict=True):
        below[1, :-1] = -decays
        column[:] = dtbtrs(below, column, uplo="L", diag="U")[0]
    return right.T.reshape(steps + 1, *start.shape)


def accumulated_within(start: Array, added: Array, low: Array, high: Array) -> Array:
    """z[i + 1] = z[i] + added[i], clipped to bounds, from a start within them on, (T + 1, ...): the play operator."""
    steps, shape = len(added), added.shape[1:]
    start, low, high = (np.broadcast_to(each, shape) for each in (start, low, high))
    out = np.empty((start.size, steps + 1))
    columns = added.reshape(steps, start.size).T
    for row, column, *limits in zip(out, columns, start.flat, low.flat, high.flat, strict=True):
        row[:] = _within(column, *map(float, limits))
    return out.T.reshape(steps + 1, *shape)


def _within(added: Array, start: float, low: float, high: float) -> Array:
    """From one turn to the next the sum goes one way, so that it is clipped as a whole: a loop over the turns does."""
    total = np.concatenate([[0.0], np.cumsum(added)])
    moving = np.flatnonzero(added)
    is_turn = np.diff(added[moving] > 0)
    turns = np.concatenate([[0], moving[1:][is_turn], [len(added)]])
    z, begins = start, []
    for way in np.diff(total[turns]).tolist():
        begins.append(z)
        z = min(max(z + way, low), high)
    ahead = np.repeat(np.array(begins) - total[turns[:-1]], np.diff(turns))
    return np.concatenate([[start], np.clip(total[1:] + ahead, low, high)])
