"""What stands above noise, where some rows are less sure than others."""

import numpy as np
import pytest

from diagnosis.noise_excess import NoiseExcess, noise_excess, row_weights

NOISE = np.array([0.3, 1.3, 2.0])
ROWS, DRAWS = 2000, 4


def variance_of_rows() -> np.ndarray:
    """Variances (3, ROWS): a few rows that are hardly known at all, and many that are known half as well."""
    rng = np.random.default_rng(0)
    part, most = np.array([[0.02], [0.3], [0.7]]), np.array([[100.0], [10.0], [6.0]])
    return most * (rng.random((3, ROWS)) < part) * rng.random((3, ROWS)) ** 2


def drawn(count: int, input_variance: np.ndarray, seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [np.sqrt(NOISE[:, None] ** 2 + input_variance) * rng.normal(size=input_variance.shape) for _ in range(count)]


def test_weights_know_noise_from_what_else_is_unsure() -> None:
    input_variance = variance_of_rows()
    (trust,) = row_weights([drawn(DRAWS, input_variance, 1)], [input_variance])
    most = input_variance.argmax(axis=1)
    rows = np.arange(3)
    variance = input_variance[rows, most] / (1 / trust[rows, most] ** 2 - 1)
    # of 8000 values a variance is known to 1.6 %, of those that count less to some more
    np.testing.assert_allclose(variance, NOISE**2, rtol=4 * np.sqrt(2 / (ROWS * DRAWS)) * 1.5)


def test_what_is_as_unsure_as_it_is_said_to_be_does_not_stand_above_noise() -> None:
    input_variance = variance_of_rows()
    ratios = [
        noise_excess(drawn(1, input_variance, 10 + k), [drawn(DRAWS, input_variance, 50 + k)], [input_variance]).ratio
        for k in range(20)
    ]
    # 1 / sqrt(2 * 2000) of the recording's, half of that of its four draws'
    own = np.sqrt((1 + 1 / DRAWS) / (2 * ROWS))
    assert np.mean(ratios) == pytest.approx(1.0, abs=4 * own / np.sqrt(60) * 1.5)
    assert np.abs(np.array(ratios) - 1).max() < 6 * own
    loud = [2 * one for one in drawn(1, input_variance, 99)]
    assert noise_excess(loud, [drawn(DRAWS, input_variance, 98)], [input_variance]).above_noise


def test_what_a_better_model_leaves_is_weighed_in_the_same_unit_as_before() -> None:
    """3.2 N were 24 times a floor that wrong numbers had made four times as high; the .9 N that hysteresis left seemed as much."""
    before = NoiseExcess(np.array([3.2, 1.0]), np.array([0.16, 1.0]))
    after = NoiseExcess(np.array([0.9, 1.0]), np.array([0.04, 1.0]))
    assert after.energy > before.energy
    assert after.share_of(before) == pytest.approx((0.9**2 - 0.04**2) / (3.2**2 - 0.16**2))
    assert after.share_of(before, slice(1, None)) == 1.0
    assert before.share_of(after) == pytest.approx(1 / after.share_of(before))
