"""What chance takes, on one nuisance and one effect made up: each of its two sources by itself, against a formula by hand."""

from typing import Any

import numpy as np
import pytest

from diagnosis.comparison import Comparison

BLOCKS, WORLDS = 50, 4000
WITH_NUISANCE, OF_NUISANCE, OF_EFFECT = 6.0, 9.0, 25.0
"""products of the effect's column with the nuisance's, and of each with itself"""


def comparison(noise: float) -> Comparison:
    """A drawing's error with a sigma of one, an effect, and draws of noise of so much standard deviation in every row."""
    products = np.zeros((3, 3))
    products[0, 0], products[1, 1] = OF_NUISANCE, OF_EFFECT
    products[0, 1] = products[1, 0] = WITH_NUISANCE
    draws = np.random.default_rng(0).normal(size=(BLOCKS, 2, 64))
    root = np.linalg.cholesky(products[:2, :2] / BLOCKS)
    nothing: Any = None
    sigma = np.array([1.0, np.inf])
    return Comparison(
        linearisation=nothing,
        matrices=(),
        base_count=0,
        nuisance_count=1,
        cause_columns=np.zeros(0, dtype=int),
        groups=(),
        block_products=np.repeat(products[None] / BLOCKS, BLOCKS, axis=0),
        noise_products=noise * np.einsum("ij,bjd->bid", root, draws),
        prior_sigma=sigma,
        relaxed_sigma=sigma,
        prior_mean=np.zeros(2),
        lower_bounds=np.full(2, -np.inf),
        upper_bounds=np.full(2, np.inf),
        nuisances=nothing,
        clock_relaxed=False,
        row_count=BLOCKS,
    )


def mean_gain(noise: float) -> float:
    gains = comparison(noise).chance_gains([np.array([1])], np.random.default_rng(1), WORLDS)
    assert gains.shape == (WORLDS,)
    return float(np.mean(gains))


INFORMATION = OF_EFFECT - WITH_NUISANCE**2 / (OF_NUISANCE + 1)
"""of the effect, the nuisance free within its sigma: 21.4"""
BY_DRAWING = (WITH_NUISANCE * (1 - OF_NUISANCE / (OF_NUISANCE + 1))) ** 2 / INFORMATION
"""of an error e of the drawing the fit takes back 9/10: the effect meets 6 e/10, squared over its information"""
BY_NOISE = (
    OF_EFFECT - 2 * WITH_NUISANCE**2 / (OF_NUISANCE + 1) + OF_NUISANCE * (WITH_NUISANCE / (OF_NUISANCE + 1)) ** 2
) / INFORMATION
"""of white noise of one: the variance of column less 6/10 of the nuisance's, over the information"""
MARGIN = 4 * np.sqrt(2 / WORLDS)
"""four standard deviations of the mean of so many squares of a normal"""


def test_errors_of_the_drawing_alone_take_what_they_do() -> None:
    assert mean_gain(0.0) == pytest.approx(BY_DRAWING, rel=MARGIN)


@pytest.mark.parametrize("noise", [0.1, 1.0])
def test_noise_and_errors_of_the_drawing_add_up(noise: float) -> None:
    """64 draws of 50 blocks stand for all noise: one part in 25 more may be off."""
    assert mean_gain(noise) == pytest.approx(BY_DRAWING + noise**2 * BY_NOISE, rel=MARGIN + 4 / np.sqrt(64 * BLOCKS))


def test_the_most_of_several_choices_is_no_less_than_of_one() -> None:
    one = comparison(1.0)
    alone, both = (one.chance_gains([np.array([1])] * count, np.random.default_rng(1), WORLDS) for count in (1, 2))
    np.testing.assert_array_equal(alone, both)
