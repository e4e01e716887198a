"""Estimates recover truths, and their covariance is what many repetitions scatter by."""

import numpy as np

from xneck_foundation.least_squares import linear_least_squares


def test_error_over_sigma_has_spread_one() -> None:
    """300 noisy straight lines: z of both parameters scatters by 1 within 4 standard errors of a spread, 1/sqrt(2 n)."""
    rng = np.random.default_rng(5)
    t = np.linspace(0, 1, 40)
    D = np.column_stack([t, np.ones_like(t)])
    truth = np.array([3.0, -1.0])
    z = []
    for _ in range(300):
        fit = linear_least_squares(D, D @ truth + rng.normal(0, 0.2, len(t)))
        z.append((fit.value - truth) / fit.sigma)
    spread = np.std(z, axis=0)
    assert np.all(np.abs(spread - 1) < 4 / np.sqrt(2 * 300))


def test_what_the_data_do_not_reach_has_infinite_sigma() -> None:
    """A dead column and two columns that only appear as their sum are not identified; the third parameter still is."""
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(2, 60))
    D = np.column_stack([a, b, b, np.zeros(60)])
    fit = linear_least_squares(D, D @ [2.0, 1.0, 1.0, 0.0] + rng.normal(0, 0.01, 60))
    assert abs(fit.value[0] - 2.0) < 5 * fit.sigma[0] < 0.05
    assert np.all(np.isinf(fit.sigma[1:]))


def test_scale_of_the_columns_does_not_matter() -> None:
    rng = np.random.default_rng(3)
    D = rng.normal(size=(40, 2))
    y = D @ [1.0, 1.0] + rng.normal(0, 0.1, 40)
    scaled = linear_least_squares(D * [1e9, 1e-9], y)
    np.testing.assert_allclose(scaled.value * [1e9, 1e-9], linear_least_squares(D, y).value, rtol=1e-9)


def test_base_columns_are_those_that_the_others_do_not_make() -> None:
    """Of a, b, a + b and nothing, two are a base; the combination comes with two of the three, and a dead column never."""
    a, b = np.random.default_rng(4).normal(size=(2, 60))
    D = np.column_stack([a, b, a + b, np.zeros(60)])
    base = linear_least_squares(D, D @ [1.0, 2.0, 3.0, 0.0]).base
    assert len(base) == 2
    assert 3 not in base
    assert np.linalg.matrix_rank(D[:, base]) == 2
