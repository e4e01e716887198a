"""Splines, their priors and banded inverses against dense linear algebra and finite differences."""

import numpy as np
from scipy import sparse
from scipy.interpolate import make_interp_spline

from state_estimation.banded import add_to_band, banded_cholesky, inverse_windows
from state_estimation.spline import DEGREE, SplinePrior, knots_over


def dense(band: np.ndarray) -> np.ndarray:
    lower = np.sum([np.diag(band[k, : band.shape[1] - k], -k) for k in range(len(band))], axis=0)
    return lower + lower.T - np.diag(band[0])


def test_design_reproduces_a_quintic_and_its_derivatives() -> None:
    knots = knots_over(1.0, 4.0, 0.25)
    time = np.linspace(1.0, 4.0, 200)
    quintic = np.polynomial.Polynomial([0.3, -1.0, 0.5, 0.2, -0.1, 0.03])
    c = np.linalg.lstsq(knots.design(time).toarray(), quintic(time), rcond=None)[0]
    for d in range(3):
        expected = quintic.deriv(d)(time) if d else quintic(time)
        np.testing.assert_allclose(knots.design(time, d) @ c, expected, atol=1e-8)


def test_a_bump_is_scipys() -> None:
    """One coefficient set: the curve equals an interpolating quintic of itself."""
    knots = knots_over(0.0, 2.0, 0.1)
    time = np.linspace(0.0, 2.0, 2001)
    c = np.eye(knots.count)[knots.count // 2]
    spline = make_interp_spline(time, knots.design(time) @ c, k=DEGREE)
    np.testing.assert_allclose(knots.design(time, 1) @ c, spline.derivative(1)(time), atol=1e-6)


def test_drawn_coefficients_have_the_priors_precision_and_determinant() -> None:
    knots, prior = knots_over(0.0, 9.0, 0.1), SplinePrior(3, 4.0, 0.2, 5.0)
    precision = dense(prior.band(knots))
    np.testing.assert_allclose(np.linalg.slogdet(precision)[1], prior.log_determinant(knots), rtol=1e-9)
    # far from the start the process forgets it: its variance stays
    variance = np.diag(np.linalg.inv(precision))
    np.testing.assert_allclose(variance[-1], variance[-8], rtol=0.05)


def test_windows_of_the_inverse_are_the_inverses() -> None:
    """Of 284 blocks, more than are worked on at a time."""
    rng = np.random.default_rng(0)
    n, width = 1700, 4
    band = np.zeros((width + 1, n))
    band[1:] = rng.normal(size=(width, n))
    band[0] = 12.0
    for k in range(1, width + 1):
        band[k, n - k :] = 0.0
    whole = np.linalg.inv(dense(band))
    first = np.concatenate([[0, 3, 3], np.sort(rng.integers(0, n - 5, 400)), [n - 5]])
    windows = np.full((len(first), 5, 5), np.nan)
    for rows, parts in inverse_windows(banded_cholesky(band), 6, first, 5):
        windows[rows] = parts
    for f, part in zip(first, windows, strict=True):
        np.testing.assert_allclose(part, whole[f : f + 5, f : f + 5], atol=1e-12)
    right = rng.normal(size=(n, 2))
    np.testing.assert_allclose(banded_cholesky(band).solve(right), whole @ right, atol=1e-12)


def test_blocks_in_which_no_window_begins_give_none() -> None:
    """The last knots of a recording lie beyond its last row: where they fill a part of their own, no row is in it."""
    n, first = 1700, np.array([0, 3, 100, 1500])
    band = np.zeros((5, n))
    band[0] = 12.0
    found = [rows for rows, _ in inverse_windows(banded_cholesky(band), 6, first, 5)]
    assert found == [slice(0, 4)]


def test_halves_of_a_solution_multiply_to_the_inverses_form() -> None:
    """Also of no right sides at all, and of one that is a vector."""
    rng = np.random.default_rng(1)
    band = np.pad(rng.normal(size=(3, 40)), ((1, 0), (0, 0)))
    band[0] = 12.0
    for k in range(1, 4):
        band[k, 40 - k :] = 0.0
    cholesky, whole = banded_cholesky(band), np.linalg.inv(dense(band))
    for shape in ((40, 3), (40, 0), (40,)):
        right = rng.normal(size=shape)
        half = cholesky.solve_first_half(right)
        np.testing.assert_allclose(half.T @ half, right.T @ whole @ right, atol=1e-12)
        np.testing.assert_allclose(cholesky.solve_second_half(half), whole @ right, atol=1e-12)


def test_innovations_are_what_the_prior_weighs_and_their_transpose_is_one() -> None:
    """Squares of the innovations and of the first coefficients are the prior's quadratic form; <u, D c> = <D^T u, c>."""
    rng = np.random.default_rng(0)
    knots, prior = knots_over(0.0, 4.0, 0.1), SplinePrior(3, 6.0, 0.2, 1.7)
    c = rng.normal(size=(knots.count, 2))
    innovations = prior.innovations(knots, c)
    form = np.einsum("kq,kl,lq->q", c, dense(prior.band(knots)), c)
    assert np.allclose(np.sum(innovations**2, axis=0) + np.sum(c[:3] ** 2, axis=0) / 1.7**2, form)
    u = rng.normal(size=innovations.shape)
    assert np.isclose(np.sum(u * innovations), np.sum(prior.innovations_transposed(knots, u) * c))
    assert np.allclose(prior.scaled(3.0).innovations(knots, c), innovations / 3)


def test_a_matrix_of_sums_enters_the_band_of_their_parts() -> None:
    rng = np.random.default_rng(0)
    rows = np.triu(np.tril(rng.normal(size=(9, 9)), 2))
    matrix = rows.T @ rows
    band = np.zeros((6, 18))
    add_to_band(band, sparse.csr_array(matrix), parts=2)
    assert np.allclose(dense(band), np.kron(matrix, np.ones((2, 2))))
