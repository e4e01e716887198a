"""A marker that stands still errs the same in every frame: it counts as one measurement, and the moving ones tell its bar."""

from dataclasses import replace

import numpy as np

from mechanism.description import read_neck
from tests.paths import NECK_FILE
from tests.vision.linkage.test_linkage_fit import camera
from tests.vision.linkage.test_row_time import TIME, swinging
from tests.vision.scene import NOISE_PX, rolled
from vision.linkage.linkage_fit import LinkageFit, fit_linkage
from vision.linkage.shared_fit import LinkageOptions

NECK = read_neck(NECK_FILE)
BELIEVED = LinkageOptions(drift=False, systematic_px=0.005)
ONE_MEASUREMENT = replace(BELIEVED, standing_px=0.02)


def with_lasting_error(seed: int) -> np.ndarray:
    """Corners of a swinging arm, its base marker moved and turned by some hundredths of a pixel in all frames."""
    rng = np.random.default_rng([seed, 5])
    assert NECK.markers is not None
    shown = rolled(NECK, TIME, swinging(seed), 0.0, None)
    square = shown[0, 0] - shown[0, 0].mean(axis=0)
    wrong = rng.normal(0, 0.02, 2) + rng.normal(0, 4e-4) * np.stack([-square[:, 1], square[:, 0]], axis=-1)
    shown = shown + NOISE_PX * rng.normal(size=shown.shape)
    shown[:, 0] += wrong
    return shown


def bias(fit: LinkageFit, seed: int) -> np.ndarray:
    return (fit.alpha - swinging(seed)(TIME)).mean(axis=0)


def test_its_error_does_not_reach_the_first_joint() -> None:
    """Over six arms the first joint's bias falls to less than half, and to what sigma says."""
    believed, weighed, sigma = [], [], []
    for seed in range(10, 16):
        corners = with_lasting_error(seed)
        fits = [fit_linkage(NECK, camera(), corners, "test", options=o) for o in (BELIEVED, ONE_MEASUREMENT)]
        believed.append(bias(fits[0], seed)[0])
        weighed.append(bias(fits[1], seed)[0])
        assert fits[1].noise is not None
        sigma.append(np.sqrt(np.mean((fits[1].covariance - fits[1].noise)[:, 0, 0])))
    assert np.sqrt(np.mean(np.square(weighed))) < 0.5 * np.sqrt(np.mean(np.square(believed)))
    assert np.sqrt(np.mean(np.square(np.array(weighed) / sigma))) < 2.0


def test_an_arm_at_rest_says_less_of_its_angles() -> None:
    """Where nothing moves no other marker tells where the base is, and sigma holds its offset: .02 px of 30 mm at some 60 px."""
    still = np.repeat(with_lasting_error(10)[:1], 60, axis=0)
    still = still + NOISE_PX * np.random.default_rng(3).normal(size=still.shape)
    common = []
    for options in (BELIEVED, ONE_MEASUREMENT):
        fit = fit_linkage(NECK, camera(), still, "test", options=options)
        assert fit.noise is not None
        common.append(np.sqrt(np.mean((fit.covariance - fit.noise)[:, 0, 0])))
    assert common[1] > 1.5 * common[0]
