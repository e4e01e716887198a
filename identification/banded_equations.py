"""Least squares of equations that each depend on a few neighbouring unknowns along a recording."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

Array = NDArray[np.float64]


class BandedEquations:
    """Equations of `count` unknowns, each with unknowns no further apart than `reach`."""

    def __init__(self, count: int, reach: int) -> None:
        self._normal, self._right = np.zeros((reach + 1, count)), np.zeros(count)

    def add(self, by_unknowns: Mapping[int, Array], value: Array, stride: int) -> None:
        """Equations i, sum over k of by_unknowns[k][i] u[k + stride i] = value[i]; all (E,)."""
        for k, by_one in by_unknowns.items():
            rows = slice(k, k + stride * len(value), stride)
            self._right[rows] += by_one * value
            for other, by_other in by_unknowns.items():
                if other >= k:
                    self._normal[other - k, rows] += by_one * by_other

    def solved(self) -> Array:
        """The unknowns, (count,)."""
        return solveh_banded(self._normal, self._right, lower=True, check_finite=False)
