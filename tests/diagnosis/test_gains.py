"""The sigma of a gain on recordings that were not fitted, against the scatter of gains over many such recordings."""

import numpy as np
import pytest
from scipy.signal import lfilter

from diagnosis import law_gains
from diagnosis.held_out_gain import Gain, HeldOutResiduals, gains

ROWS, WORLDS, MOTORS = 1500, 150, 4


def side(before: np.ndarray, floor: float = 1.0) -> HeldOutResiduals:
    rng = np.random.default_rng(0)
    nothing = np.zeros(before.shape)
    return HeldOutResiduals(
        (before,), ([floor * rng.normal(size=before.shape)],), (nothing,), (0.0,), (np.arange(before.shape[1]) / 32,)
    )


def gained(seed: int, remembers: float, common: float) -> tuple[Gain, Gain]:
    """3 N and then 2 N of what remembers so much of the row before; a part of both is the same."""
    rng = np.random.default_rng(seed)
    noise = lfilter([np.sqrt(1 - remembers**2)], [1, -remembers], rng.normal(size=(3, MOTORS + 3, ROWS)), axis=2)
    own = np.sqrt(1 - common**2)
    old, new = (level * (common * noise[0] + own * noise[k]) for level, k in ((3.0, 1), (2.0, 2)))
    motor, arm = gains(side(old), side(new), MOTORS)
    return motor, arm


@pytest.mark.parametrize("common", [0.0, 0.95])
@pytest.mark.parametrize("remembers", [0.0, 0.6])
def test_a_gains_sigma_is_the_scatter_of_gains(remembers: float, common: float) -> None:
    """Over 150 worlds their scatter is known to 1/sqrt(300), sigma's mean far better. Four of it are allowed, and blocks of 50
    rows may miss a tenth of what rows remember. What both sides have in common is no part of it."""
    for k in (0, 1):
        found = [gained(seed, remembers, common)[k] for seed in range(WORLDS)]
        scatter = float(np.std([g.before - g.after for g in found]))
        stated = float(np.sqrt(np.mean([g.sigma**2 for g in found])))
        assert stated == pytest.approx(scatter, rel=4 / np.sqrt(2 * WORLDS) + 0.1)


def test_a_gain_is_the_root_of_mean_squares_by_equation() -> None:
    old = np.concatenate([np.full((4, 300), 5.0), np.full((3, 300), 0.5)])
    new = np.concatenate([np.full((2, 300), 1.0), np.full((2, 300), 7.0), np.full((3, 300), 0.1)])
    motor, arm = gains(side(old), side(new, floor=0.2), MOTORS)
    assert (motor.before, motor.after) == pytest.approx((5.0, 5.0))
    assert (arm.before, arm.after) == pytest.approx((0.5, 0.1))
    assert motor.noise_floor == pytest.approx(0.2, rel=0.1)
    assert (motor.unit, arm.unit) == ("N", "N m")
    assert motor.sigma < 1e-9


def test_what_the_fit_left_uncertain_is_part_of_the_floor() -> None:
    quiet = side(np.ones((7, 300)), floor=1e-6)
    unsure = HeldOutResiduals(quiet.residuals, quiet.noise, (np.full((7, 300), 0.09),), (0.0,), quiet.times)
    assert gains(quiet, unsure, MOTORS)[0].noise_floor == pytest.approx(0.3, rel=1e-6)


def test_a_law_is_no_louder_than_what_was_left_without_it() -> None:
    """Where noise with a law is as loud as all that was left, or louder, nothing stands above it: that explains nothing."""
    rng = np.random.default_rng(4)
    before = side(2.0 * rng.normal(size=(7, 300)))
    soft, as_loud = (side(rng.normal(size=(7, 300)), floor=floor) for floor in (1.0, 2.8))
    assert law_gains._is_no_louder(before, soft)
    assert not law_gains._is_no_louder(before, as_loud)
