"""The noise of angles by their scatter from frame to frame: read where it is not given, tested where it is."""

import numpy as np
import pytest

from identification.dataset.frames import ordinary_frames
from identification.dataset.series import Series, numbered_columns
from synchronisation.angles import Angles, checked_angles, read_angles
from synchronisation.frame_noise import frame_noise, noise_correlation
from synchronisation.held_frames import held_frames
from synchronisation.tested_sigma import with_tested_sigma
from xneck_foundation.errors import Refused

NOISE = np.radians([0.01, 0.05, 0.2])


def _film(
    rate: float = 30.0, seconds: float = 60.0, seed: int = 0, noise: np.ndarray = NOISE
) -> tuple[np.ndarray, np.ndarray]:
    """Camera times and angles of three joints that move below 3 Hz by tens of degrees; one frame in a hundred is missing."""
    rng = np.random.default_rng(seed)
    time = np.arange(int(rate * seconds)) / rate + rng.normal(0, 2e-4, int(rate * seconds))
    time = time[rng.random(len(time)) > 0.01]
    hertz, phase = rng.uniform(0.1, 3, (20, 3)), rng.uniform(0, 2 * np.pi, (20, 3))
    motion = np.sum(0.1 / (1 + hertz**3) * np.sin(2 * np.pi * hertz * time[:, None, None] + phase), axis=1)
    return time, motion + noise * rng.normal(size=motion.shape)


def _given(factor: float, common: float = 0.0) -> Angles:
    time, alpha = _film()
    sigma = np.broadcast_to(factor * NOISE, alpha.shape)
    shared = np.full(alpha.shape, common)
    return Angles(time=time, alpha=alpha, sigma=np.hypot(sigma, shared), common=shared)


@pytest.mark.parametrize(("rate", "seconds"), [(30, 60), (60, 60), (25, 60), (60, 15), (120, 60)])
def test_noise_is_read_within_ten_percent(rate: float, seconds: float) -> None:
    ratios = []
    for seed in range(4):
        time, alpha = _film(rate, seconds, seed)
        ratios.append(frame_noise(time, alpha, np.broadcast_to(NOISE, alpha.shape)).ratio)
    assert np.max(np.abs(np.array(ratios) - 1)) < 0.13
    assert np.mean(np.abs(np.array(ratios) - 1) < 0.1) > 0.9


def test_the_ratio_scatters_as_its_sigma_says() -> None:
    """Of 80 joints at rest their scatter is known to 8 %."""
    time, noise = np.arange(150) / 100, NOISE[1] * np.random.default_rng(6).normal(size=(150, 80))
    read = frame_noise(time, noise, np.full(noise.shape, NOISE[1]))
    assert 0.8 < np.std(read.ratio) / np.mean(read.ratio_sigma) < 1.25


@pytest.mark.parametrize(("rate", "seconds"), [(4, 60), (30, 2), (15, 60)])
def test_frames_too_few_or_too_far_apart_do_not_tell(rate: float, seconds: float) -> None:
    time, alpha = _film(rate, seconds)
    noise = frame_noise(time, alpha, np.broadcast_to(NOISE, alpha.shape))
    assert np.isnan(noise.ratio[0])
    assert noise.bound[0] > 0.9


@pytest.mark.parametrize("seed", range(4))
def test_noise_of_bars_is_found_in_the_angles_between_them(seed: int) -> None:
    """Joints that share a bar have noise of opposite sign: what is left of white noise in F frames errs by 1/sqrt(.6 F)."""
    time, motion = _film(seed=seed, noise=np.zeros(3))
    bars = NOISE[1] * np.random.default_rng(100 + seed).normal(size=motion.shape)
    seen = motion + bars - np.pad(bars, ((0, 0), (1, 0)))[:, :-1]
    expected = np.array([[1, -np.sqrt(0.5), 0], [-np.sqrt(0.5), 1, -0.5], [0, -0.5, 1]])
    sigma = np.broadcast_to(NOISE[1] * np.sqrt([1, 2, 2]), motion.shape)
    assert np.abs(noise_correlation(time, seen, sigma) - expected).max() < 4 / np.sqrt(0.6 * len(time))


@pytest.mark.parametrize("seed", range(8))
def test_independent_noise_stays_independent(seed: int) -> None:
    time, alpha = _film(seed=seed)
    np.testing.assert_array_equal(noise_correlation(time, alpha, np.broadcast_to(NOISE, alpha.shape)), np.eye(3))


@pytest.mark.parametrize("rate", [4, 8, 10])
@pytest.mark.parametrize("seed", range(3))
def test_motion_that_joints_share_is_no_noise_that_they_share(rate: int, seed: int) -> None:
    """Motion up to 5 Hz, faster than so few frames show."""
    rng, time = np.random.default_rng(seed), np.arange(60 * rate) / rate
    hertz, phase = rng.uniform(0.1, 5, (30, 1)), rng.uniform(0, 2 * np.pi, (30, 1))
    motion = np.sum(0.1 / (1 + hertz**2) * np.sin(2 * np.pi * hertz * time + phase), axis=0)
    alpha = motion[:, None] * [1, 0.7, -0.5] + NOISE[1] * rng.normal(size=(len(time), 3))
    np.testing.assert_array_equal(noise_correlation(time, alpha, np.full(alpha.shape, NOISE[1])), np.eye(3))


def test_no_sum_of_joints_is_without_noise() -> None:
    time, alpha = _film()
    alpha = np.column_stack([alpha[:, 0], -alpha[:, 0], alpha[:, 2]])
    found = noise_correlation(time, alpha, np.broadcast_to(NOISE, alpha.shape))
    assert np.linalg.eigvalsh(found).min() > 5e-3
    assert found[0, 1] < -0.98


def test_single_frames_that_stand_out_are_named_and_change_nothing() -> None:
    time, alpha = _film()
    stated = np.broadcast_to(NOISE, alpha.shape)
    clean = frame_noise(time, alpha, stated)
    assert not np.any(clean.outlying)
    wrong = np.arange(50, len(time) - 50, 97)
    alpha[wrong, 1] += np.radians(1.0)
    noise = frame_noise(time, alpha, stated)
    assert np.flatnonzero(noise.outlying[:, 1]).tolist() == wrong.tolist()
    assert np.allclose(noise.outlying[wrong, 1], np.radians(1.0), rtol=0.4)
    assert noise.ratio == pytest.approx(clean.ratio, rel=0.1)


def test_a_true_sigma_stays_and_nothing_is_said() -> None:
    angles = _given(1.0, common=np.radians(0.05))
    tested, warnings = with_tested_sigma(angles)
    assert warnings == ()
    assert np.allclose(tested.sigma, angles.sigma)


def test_a_sigma_that_is_too_small_is_raised_and_said() -> None:
    tested, warnings = with_tested_sigma(_given(0.4, common=np.radians(0.05)))
    assert np.allclose(np.median(tested.white_sigma, axis=0), NOISE, rtol=0.12)
    (warning,) = warnings
    assert "alpha1, alpha2, alpha3" in warning
    assert "too small" in warning
    assert tested.noise is not None
    assert tested.noise["scatter"] == pytest.approx([2.5, 2.5, 2.5], rel=0.12)


def test_a_sigma_that_is_too_large_is_said_and_stays() -> None:
    angles = _given(6.0)
    tested, warnings = with_tested_sigma(angles)
    assert np.allclose(tested.sigma, angles.sigma)
    assert "from frame to frame" in warnings[0]


def test_a_sigma_in_degrees_is_refused() -> None:
    with pytest.raises(Refused, match="sigma is in degrees"):
        with_tested_sigma(_given(180 / np.pi))


def test_angles_without_sigma_have_that_of_their_frames(tmp_path) -> None:
    time, alpha = _film()
    rows = "\n".join(",".join(f"{v:.9f}" for v in row) for row in np.column_stack([time, alpha]))
    (tmp_path / "alpha.csv").write_text(f"time,alpha1,alpha2,alpha3\n{rows}\n")
    angles = read_angles(tmp_path / "alpha.csv", 3)
    assert np.allclose(np.median(angles.sigma, axis=0), NOISE, rtol=0.12)
    assert with_tested_sigma(angles)[1] == ()


def test_what_no_frames_tell_is_said(tmp_path) -> None:
    time, alpha = _film(rate=5)
    rows = "\n".join(",".join(f"{v:.9f}" for v in row) for row in np.column_stack([time, alpha]))
    (tmp_path / "alpha.csv").write_text(f"time,alpha1,alpha2,alpha3\n{rows}\n")
    angles = read_angles(tmp_path / "alpha.csv", 3)
    (warning,) = with_tested_sigma(angles)[1]
    assert "too far apart" in warning
    assert np.nanmax(angles.sigma) <= np.radians(0.1)


def test_angles_that_a_slower_tracker_holds_are_left_out(tmp_path) -> None:
    """Every second frame holds the angles of the frame before; those that are left are what the tracker saw."""
    time, alpha = _film()
    held = alpha.copy()
    held[1::2] = alpha[: 2 * (len(alpha) // 2) : 2]
    columns = numbered_columns("alpha", held)
    angles = checked_angles(Series(time, columns), alpha.shape[1], "angles.csv", {})
    seen = angles.complete
    assert seen[::2].all()
    assert seen[1::2].mean() < 0.05
    assert any("hold the angles of the frame before" in w for w in with_tested_sigma(angles)[1])


def test_an_arm_at_rest_holds_no_angles() -> None:
    """To the last digit, in rests of 2 and 3 s before and between motions; of 20 held frames 19 are found."""
    time = np.arange(0, 20, 1 / 30)
    moves = (time > 2) & (time < 9) | (time > 12)
    swing = np.where(moves, 0.3 * (1 - np.cos(2 * np.pi * np.where(time < 10, time - 2, time - 12) / 1.4)), 0.0)
    alpha = np.round(np.stack([swing, 0.5 * swing], axis=1), 4)
    assert not held_frames(alpha).any()
    stuck = alpha.copy()
    stuck[100:120] = alpha[100]
    assert np.flatnonzero(held_frames(stuck)).tolist() == list(range(101, 120))


def test_frames_of_a_far_larger_sigma_have_no_say_where_others_do() -> None:
    alpha = np.zeros((100, 2))
    sigma = np.full((100, 2), 1e-3)
    sigma[::50, 1] = 0.3
    alpha[3, 0] = np.nan
    assert np.flatnonzero(~ordinary_frames(alpha, sigma)).tolist() == [0, 3, 50]
    sigma[10:70, 0] = 1e-2  # most of them: what is usual is what most have
    assert ordinary_frames(alpha, sigma).sum() == 97
