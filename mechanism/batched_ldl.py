"""Many small symmetric positive definite systems at once: A = L D L^T without pivoting, the batch B on the last axis."""

from mechanism.arm import Array


def ldl_factor(A: Array) -> Array:
    """A (n, n, B) -> L below the diagonal and D on it, in a new array of that shape."""
    factors = A.copy()
    for j in range(len(A) - 1):
        below = factors[j + 1 :, j] / factors[j, j]
        factors[j + 1 :, j + 1 :] -= below[:, None] * factors[j, None, j + 1 :]
        factors[j + 1 :, j] = below
    return factors


def ldl_solve(factors: Array, b: Array) -> Array:
    """x of A x = b, (n, B), from the factors that `ldl_factor` gives."""
    n = len(factors)
    x = b.copy()
    for j in range(n - 1):
        x[j + 1 :] -= factors[j + 1 :, j] * x[j]
    for j in range(n):
        x[j] /= factors[j, j]
    for j in range(n - 1, 0, -1):
        x[:j] -= factors[j, :j] * x[j]
    return x
