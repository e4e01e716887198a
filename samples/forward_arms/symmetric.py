"""Small symmetric positive systems, many at once: A = L L^T with the batch last."""

import numpy as np

from samples.forward_arms.plant import Array


def factor(A: Array) -> Array:
    """(N, N, B) -> L below the diagonal, and the diagonal's reciprocals on it."""
    out = A.copy()
    for j in range(len(A)):
        for k in range(j):
            out[j:, j] -= out[j:, k] * out[j, k]
        out[j, j] = 1 / np.sqrt(out[j, j])
        out[j + 1 :, j] *= out[j, j]
    return out


def solve(factors: Array, b: Array) -> Array:
    """x of A x = b, (N, B)."""
    n, x = len(b), b.copy()
    for i in range(n):
        x[i] *= factors[i, i]
        if i + 1 < n:
            x[i + 1 :] -= factors[i + 1 :, i] * x[i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            x[i] -= factors[k, i] * x[k]
        x[i] *= factors[i, i]
    return x
