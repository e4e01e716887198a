"""Least squares between bounds, against scipy."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from diagnosis.bounded_least_squares import bounded_minimum


@pytest.mark.parametrize("seed", range(20))
def test_the_minimum_between_bounds_is_scipys(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A, right = rng.normal(size=(30, 8)), 30 * rng.normal(size=30)
    low = np.where(rng.random(8) < 0.7, -rng.uniform(0, 2, 8), -np.inf)
    high = np.where(rng.random(8) < 0.7, rng.uniform(0, 2, 8), np.inf)
    found = bounded_minimum(A.T @ A, A.T @ right, low, high)
    best = lsq_linear(A, right, (low, high), tol=1e-14)
    assert np.any(best.active_mask != 0)
    assert np.all((found >= low) & (found <= high))
    assert 0.5 * np.sum((A @ found - right) ** 2) == pytest.approx(best.cost, rel=1e-6)
