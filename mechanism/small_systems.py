"""Many small symmetric systems at once, one a lane: A = L D L^T without pivots, for A of positive definite kind."""

from mechanism.arm import Array


def factored(A: Array) -> Array:
    """A (n, n, lanes) -> L below the diagonal and D on it, in a new array of that shape."""
    out = A.copy()
    for j in range(len(A) - 1):
        below = out[j + 1 :, j] / out[j, j]
        out[j + 1 :, j + 1 :] -= below[:, None] * out[j, None, j + 1 :]
        out[j + 1 :, j] = below
    return out


def solved(factors: Array, b: Array) -> Array:
    """x of A x = b, (n, lanes), from `factored`."""
    n = len(factors)
    x = b.copy()
    for j in range(n - 1):
        x[j + 1 :] -= factors[j + 1 :, j] * x[j]
    for j in range(n):
        x[j] /= factors[j, j]
    for j in range(n - 1, 0, -1):
        x[:j] -= factors[j, :j] * x[j]
    return x
