"""The smoother on signals that are not of its own model: sums of sines, sampled late and early."""

import numpy as np
import pytest

from state_estimation.smoother import smooth_signal
from xneck_foundation.errors import Refused

SIGMA = np.radians(0.1)


def sines(t: np.ndarray, rng: np.random.Generator, derivative: int = 0) -> np.ndarray:
    """Eight sines of 0.1 to 2 Hz with random phases, peak about 35 deg, and their derivatives."""
    w = 2 * np.pi * np.linspace(0.13, 2.0, 8)
    a, p = 0.3 / np.arange(1, 9), rng.uniform(0, 2 * np.pi, 8)
    return np.sum(a * w**derivative * np.sin(np.outer(t, w) + p + derivative * np.pi / 2), axis=1)


def frames(rng: np.random.Generator) -> np.ndarray:
    return np.arange(900) / 30 + rng.uniform(-1e-3, 1e-3, 900)


def test_error_is_within_its_covariance_and_below_raw_noise() -> None:
    """NEES per dimension over 10 seeds between 0.6 and 1.3: honest; of the noise less is left than a 5 Hz low-pass leaves,
    sqrt(2 * 5 Hz / 30 Hz)."""
    nees, errors = [], []
    at = np.arange(0.5, 29.4, 0.01)
    for seed in range(10):
        t = frames(np.random.default_rng([seed, 1]))
        y = sines(t, np.random.default_rng(seed)) + np.random.default_rng([seed, 2]).normal(0, SIGMA, len(t))
        smoothed = smooth_signal(t, y, np.full(len(t), SIGMA), at)
        truth = [sines(at, np.random.default_rng(seed), d) for d in range(3)]
        e = np.stack([smoothed.value, smoothed.d1, smoothed.d2], axis=-1) - np.stack(truth, axis=-1)
        nees.append(np.mean(np.einsum("ti,tij,tj->t", e, np.linalg.inv(smoothed.covariance), e)) / 3)
        errors.append(np.std(e[:, 0]))
    assert 0.6 < np.mean(nees) < 1.3
    assert np.mean(errors) < np.sqrt(2 * 5 / 30) * SIGMA


def test_a_gap_of_a_second_is_bridged_with_a_sigma_to_match() -> None:
    """The prior is not the truth's, so z may spread by up to 2 there; a gap that is passed over gives z of 10 and more."""
    z = []
    for seed in range(20):
        t = frames(np.random.default_rng([seed, 1]))
        y = sines(t, np.random.default_rng(seed)) + np.random.default_rng([seed, 2]).normal(0, SIGMA, len(t))
        y[(t > 14) & (t < 15)] = np.nan
        at = np.array([10.5, 14.5])
        smoothed = smooth_signal(t, y, np.full(len(t), SIGMA), at)
        sigma = np.sqrt(smoothed.covariance[:, 0, 0])
        assert sigma[1] > 3 * sigma[0]
        z.append((smoothed.value - sines(at, np.random.default_rng(seed)))[1] / sigma[1])
    assert np.sqrt(np.mean(np.square(z))) < 2


def test_given_states_at_samples_the_bridge_meets_them() -> None:
    """Evaluated at its own samples from either side, value and covariance are continuous."""
    t = frames(np.random.default_rng(3))
    y = sines(t, np.random.default_rng(3)) + np.random.default_rng(4).normal(0, SIGMA, len(t))
    s = np.full(len(t), SIGMA)
    before, after = smooth_signal(t, y, s, t[400:500] - 1e-9), smooth_signal(t, y, s, t[400:500] + 1e-9)
    np.testing.assert_allclose(before.value, after.value, atol=1e-7)
    np.testing.assert_allclose(before.covariance[:, 0, 0], after.covariance[:, 0, 0], rtol=1e-4)


def test_nothing_is_extrapolated() -> None:
    t = frames(np.random.default_rng(0))
    with pytest.raises(Refused, match="outside"):
        smooth_signal(t, np.sin(t), np.full(len(t), SIGMA), np.array([1.0, 31.0]))
