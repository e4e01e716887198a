"""The scatter from frame to frame corrects a sigma that is too small, and leaves one that is right."""

import numpy as np

from vision.linkage.linkage_fit import LinkageFit
from vision.noise_by_frames import with_noise_by_frames

FRAMES = 600
STATED = np.radians([0.01, 0.02, 0.03])


def fit_of(seed: int, times: np.ndarray) -> tuple[LinkageFit, np.ndarray, np.ndarray]:
    """A fit that states STATED and has so many `times` of it in each joint, the frames' times, and the true angles.

    The motion is a chirp with a bump that no spline was made for; common errors of a tenth of a degree are part of the covariance.
    """
    rng = np.random.default_rng([31, seed])
    time = np.arange(FRAMES) / 30
    swing = np.sin(2 * np.pi * (0.1 * time + 0.02 * time**2))[:, None] * [0.4, -0.2, 0.3]
    motion = swing + 0.05 * np.exp(-((time - rng.uniform(5, 15)) ** 2) / 0.02)[:, None]
    noise = np.broadcast_to(np.diag(STATED**2), (FRAMES, 3, 3)).copy()
    alpha = motion + rng.normal(0, 1, (FRAMES, 3)) * times * STATED
    common = np.radians(0.1) ** 2 * np.eye(3)
    fit = LinkageFit(
        alpha=alpha,
        covariance=noise + common,
        rvec=np.zeros(3),
        tvec=np.zeros(3),
        pose_sigma=np.zeros(6),
        corner_sigma_px=0.03,
        residual_px=np.zeros(FRAMES),
        noise=noise,
    )
    return fit, time, motion


def test_noise_that_is_larger_than_stated_is_found() -> None:
    """Twice, three times, and as stated. The finest spline leaves 72 degrees of freedom, so 8 % of chance; the bound is 3.5 times
    that."""
    times = np.array([2.0, 3.0, 1.0])
    for seed in range(5):
        fit, time, _ = fit_of(seed, times)
        told = with_noise_by_frames(fit, time)
        assert told.noise is not None
        np.testing.assert_allclose(np.sqrt(np.diagonal(told.noise[0])), times * STATED, rtol=0.29)
        # what all frames share stays as it was
        assert fit.noise is not None
        np.testing.assert_allclose(told.covariance - told.noise, fit.covariance - fit.noise, atol=1e-15)
        assert told.notes["noise_by_frames"] == list(told.noise_by_frames)


def test_a_sigma_that_is_right_stays() -> None:
    """Of 60 joints at most 7 are raised: one in 40 is expected, and more than 7 have a chance of 1 in 1000."""
    raised = []
    for seed in range(20):
        fit, time, _ = fit_of(100 + seed, np.ones(3))
        raised += [factor > 1 for factor in with_noise_by_frames(fit, time).noise_by_frames]
    assert sum(raised) <= 7


def test_frames_that_are_too_few_change_nothing() -> None:
    fit, time, _ = fit_of(1, 3 * np.ones(3))
    few = LinkageFit(
        alpha=fit.alpha[:40],
        covariance=fit.covariance[:40],
        rvec=fit.rvec,
        tvec=fit.tvec,
        pose_sigma=fit.pose_sigma,
        corner_sigma_px=0.03,
        residual_px=np.zeros(40),
        noise=fit.covariance[:40],
    )
    told = with_noise_by_frames(few, time[:40])
    np.testing.assert_array_equal(told.covariance, few.covariance)
