"""Steps z -> decay z + added, one after another along a recording, without a loop over its rows."""

import numpy as np

from mechanism.arm import Array


def accumulated(start: Array, decay: Array, added: Array, bounds: tuple[Array, Array] | None = None) -> Array:
    """z[i + 1] = decay[i] z[i] + added[i], clipped to bounds if there are any, from a start on, (T + 1, ...).

    Successive steps compose to one step of the same form: they are composed within stretches of rows, all stretches at once, and
    the stretches are then run through one after the other.
    """
    steps, rest = len(decay), decay.shape[1:]
    length = max(1, round(np.sqrt(steps)))
    padding = -steps % length
    g = np.concatenate([decay, np.ones((padding, *rest))]).reshape(-1, length, *rest)
    c = np.concatenate([added, np.zeros((padding, *rest))]).reshape(-1, length, *rest)
    # (stretch, step) with steps first: each is one piece of memory
    g, c = (np.ascontiguousarray(np.moveaxis(a, 1, 0)) for a in (g, c))
    G, C, *limits = g.copy(), c.copy(), *(np.broadcast_to(bound, g.shape).copy() for bound in bounds or ())
    for i in range(1, length):
        G[i] *= G[i - 1]
        for term in (C, *limits):
            term[i] = g[i] * term[i - 1] + c[i]
        for limit in limits:
            np.clip(limit[i], *(bounds or ()), out=limit[i])
    out = np.empty_like(g)
    z = start
    for stretch in range(g.shape[1]):
        out[:, stretch] = G[:, stretch] * z + C[:, stretch]
        if bounds:
            np.clip(out[:, stretch], *(limit[:, stretch] for limit in limits), out=out[:, stretch])
        z = out[-1, stretch]
    return np.concatenate([start[None], np.moveaxis(out, 0, 1).reshape(-1, *rest)[:steps]])
