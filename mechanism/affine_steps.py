"""Steps z -> decay z + added, one after another along a recording, without a loop over its rows."""

import numpy as np
from scipy.linalg.lapack import dtbtrs  # pyright: ignore[reportAttributeAccessIssue] (made when imported)

from mechanism.arm import Array


def accumulated(start: Array, decay: Array, added: Array, bounds: tuple[Array, Array] | None = None) -> Array:
    """z[i + 1] = decay[i] z[i] + added[i], clipped to bounds if there are any, from a start on, (T + 1, ...)."""
    start = np.broadcast_to(start, decay.shape[1:])
    return _bounded(start, decay, added, bounds) if bounds else _unbounded(start, decay, added)


def _unbounded(start: Array, decay: Array, added: Array) -> Array:
    """As equations in all rows at once, whose matrix is a diagonal of ones with the decays below it: solved from above."""
    steps = len(decay)
    below, right = np.ones((2, steps + 1), order="F"), np.empty((start.size, steps + 1))
    right[:, 0], right[:, 1:] = start.ravel(), added.reshape(steps, start.size).T
    for column, decays in zip(right, decay.reshape(steps, start.size).T, strict=True):
        below[1, :-1] = -decays
        column[:] = dtbtrs(below, column, uplo="L", diag="U")[0]
    return right.T.reshape(steps + 1, *start.shape)


def _bounded(start: Array, decay: Array, added: Array, bounds: tuple[Array, Array]) -> Array:
    """Successive steps compose to one step of the same form: they are composed within stretches of rows, all stretches at once,
    and the stretches are then run through one after the other."""
    steps, rest = len(decay), decay.shape[1:]
    length = max(1, round(np.sqrt(steps)))
    padding = -steps % length
    g = np.concatenate([decay, np.ones((padding, *rest))]).reshape(-1, length, *rest)
    c = np.concatenate([added, np.zeros((padding, *rest))]).reshape(-1, length, *rest)
    # (stretch, step) with steps first: each is one piece of memory
    g, c = (np.ascontiguousarray(np.moveaxis(a, 1, 0)) for a in (g, c))
    G, C, *limits = g.copy(), c.copy(), *(np.broadcast_to(bound, g.shape).copy() for bound in bounds)
    for i in range(1, length):
        G[i] *= G[i - 1]
        for term in (C, *limits):
            term[i] = g[i] * term[i - 1] + c[i]
        for limit in limits:
            _clip(limit[i], *bounds)
    out = np.empty_like(g)
    z = start
    for stretch in range(g.shape[1]):
        out[:, stretch] = G[:, stretch] * z + C[:, stretch]
        _clip(out[:, stretch], *(limit[:, stretch] for limit in limits))
        z = out[-1, stretch]
    return np.concatenate([start[None], np.moveaxis(out, 0, 1).reshape(-1, *rest)[:steps]])


def _clip(values: Array, lower: Array, upper: Array) -> None:
    """In place; `np.clip` takes longer than that for the few values of one step."""
    np.maximum(values, lower, out=values)
    np.minimum(values, upper, out=values)
