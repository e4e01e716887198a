"""Small symmetric positive systems, many at once: A = L L^T with the batch last."""

import numpy as np

from samples.forward_arms.plant import Array

Factors = list[list[Array]]
"""of each row those up to the diagonal, (B,); on the diagonal reciprocals"""


def factor(A: Array) -> Factors:
    """L of A (N, N, B)."""
    out: Factors = [[row[j] for j in range(i + 1)] for i, row in enumerate(A)]
    for j, own in enumerate(out):
        for k in range(j):
            for row in out[j:]:
                row[j] = row[j] - row[k] * own[k]
        own[j] = 1 / np.sqrt(own[j])
        for row in out[j + 1 :]:
            row[j] = row[j] * own[j]
    return out


def solve(factors: Factors, b: Array) -> Array:
    """x of A x = b, (N, B)."""
    x = list(b)
    for i, row in enumerate(factors):
        x[i] = x[i] * row[i]
        for k in range(i + 1, len(x)):
            x[k] = x[k] - factors[k][i] * x[i]
    for i in range(len(x) - 1, -1, -1):
        for k in range(i + 1, len(x)):
            x[i] = x[i] - factors[k][i] * x[k]
        x[i] = x[i] * factors[i][i]
    return np.array(x)
