"""The covariance of a template fit on numbers made up: noise that is white, and noise that a codec repeats over its blocks."""

import numpy as np
import pytest

from vision.markers.robust_weights import block_variance, influence_slope, residual_scale, tukey_weights

BLOCKS, WIDTH, MARKERS = 60, 16, 40
BEGINS = np.arange(0, BLOCKS * WIDTH, WIDTH)


def variance_said(by_block: float, own: float) -> float:
    """Mean over markers of `block_variance` for noise of so much standard deviation a block, and a pixel."""
    rng = np.random.default_rng(0)
    n = BLOCKS * WIDTH
    # derivatives are alike within a block, as those of neighbouring pixels are
    D = np.repeat(rng.normal(size=(MARKERS, 8, BLOCKS)), WIDTH, axis=2)
    noise = np.repeat(rng.normal(0, by_block, (MARKERS, BLOCKS)), WIDTH, axis=1) + rng.normal(0, own, (MARKERS, n))
    inverse = np.asarray(np.linalg.inv(D @ np.swapaxes(D, 1, 2)), dtype=np.float64)
    fitted = np.swapaxes(D, 1, 2) @ inverse @ (D @ noise[..., None])
    residual = (noise - fitted[..., 0]).astype(np.float32)
    D, weight = D.astype(np.float32), np.ones((MARKERS, n), dtype=np.float32)
    return float(np.mean(block_variance(D, inverse, weight, residual, [BEGINS] * MARKERS)))


@pytest.mark.parametrize(("by_block", "own", "true"), [(0.0, 2.0, 4.0), (2.0, 0.0, 64.0), (1.0, 2.0, 20.0)])
def test_errors_that_a_block_repeats_count_as_often_as_they_are_repeated(
    by_block: float, own: float, true: float
) -> None:
    """A sum of 16 equal errors has 16 times the variance of a sum of 16 independent ones.

    Eight directions of 40 markers: sqrt(2 / 320), of which four are allowed, and the leverage is known to some per cent."""
    assert variance_said(by_block, own) == pytest.approx(true, rel=4 * np.sqrt(2 / 320) + 0.05)


def test_tukeys_weights_and_their_slope() -> None:
    """(1 - (r / 5 s)^2)^2 within five scales and nothing beyond; d(r w)/dr = (1 - z)(1 - 5 z), z = (r / 5 s)^2, by hand."""
    residual = np.array([[0.0, 2.5, 5.0, 9.0]], dtype=np.float32)
    np.testing.assert_allclose(tukey_weights(residual, np.ones(1)), [[1.0, 0.5625, 0.0, 0.0]], atol=1e-6)
    np.testing.assert_allclose(tukey_weights(2 * residual, 2 * np.ones(1)), [[1.0, 0.5625, 0.0, 0.0]], atol=1e-6)
    slope = influence_slope(residual[:, :2], np.ones(1), np.ones((1, 2), dtype=bool))
    assert float(slope[0]) == pytest.approx((1.0 + 0.75 * (1 - 1.25)) / 1.5625, rel=1e-6)


def test_the_scale_of_residuals_does_not_see_a_thing_across() -> None:
    """Normal noise of 3 grey levels with a tenth far off: 1.4826 median |r|, which a tenth raises by some 13 %."""
    rng = np.random.default_rng(1)
    residual = rng.normal(0, 3, (1, 9000)).astype(np.float32)
    used = np.ones(residual.shape, dtype=bool)
    clean = float(residual_scale(residual, used)[0])
    assert clean == pytest.approx(3.05, rel=4 * 1.17 / np.sqrt(3000))
    residual[:, ::10] = 200
    assert clean < float(residual_scale(residual, used)[0]) < 1.25 * clean


def test_rounding_below_zero_is_no_end_of_the_measurement() -> None:
    """The normal matrix of a tag of 11 px was not positive any more in some builds of numpy, and a video ended in a traceback."""
    rng = np.random.default_rng(4)
    D = rng.normal(size=(1, 8, 400)).astype(np.float32)
    weight, residual = np.ones((1, 400), np.float32), rng.normal(size=(1, 400)).astype(np.float32)
    inverse = np.asarray(np.linalg.inv(D.astype(float) @ np.swapaxes(D, 1, 2)), dtype=np.float64)
    right = block_variance(D, inverse, weight, residual, [np.arange(0, 400, 10)])
    size, axes = np.linalg.eigh(inverse[0])
    size[0] = -1e-9 * size[-1]
    rounded = (axes * size) @ axes.T
    assert np.isfinite(block_variance(D, rounded[None], weight, residual, [np.arange(0, 400, 10)])).all()
    assert 0.3 < right[0] < 3.0
