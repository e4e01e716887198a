"""Commands that a drive holds: each row's force acts from its row to the next, or as much later as the drive is late."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def mean_held_force(force: Array, edges: Array) -> Array:
    """Means of forces (T, M) between edges (E,), rising, counted in rows from the first: (E - 1, M).

    Before its row the first force acts, and after the last row the last one goes on.
    """
    impulse = np.vstack([np.zeros(force.shape[1]), np.cumsum(force, axis=0)])
    rows = np.arange(len(impulse))
    at_edges = np.stack([np.interp(edges, rows, column) for column in impulse.T]).T
    at_edges += np.minimum(edges, 0.0)[:, None] * force[0] + np.maximum(edges - len(force), 0.0)[:, None] * force[-1]
    return np.diff(at_edges, axis=0) / np.diff(edges)[:, None]
