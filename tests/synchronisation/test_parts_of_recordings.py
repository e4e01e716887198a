"""Logs that hold a part of the video, and short ones: what is right is taken, and what is told by little is not believed."""

from typing import Any, cast

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.stats import t as student

from identification.dataset.series import Series, numbered_columns
from mechanism.arm import arm_of
from mechanism.cable_lengths import lengths
from mechanism.description import read_neck
from synchronisation import force_plausibility, log_regression
from synchronisation.angles import Angles
from synchronisation.clocks.clock import fit_clock
from synchronisation.clocks.coarse_alignment import CableSpeeds, align_coarsely, cable_speeds
from synchronisation.clocks.exchanged_labels import check_labels
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.force_plausibility import check_forces
from synchronisation.log_plausibility import check_log_meaning
from synchronisation.log_regression import Factors
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

NECK = read_neck(NECK_FILE)
ARM = arm_of(NECK)
SHIFT = 1.25


def film_and_log(seed: int, rests: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times and angles of 40 s of frames, and times and motor angles of a log 1.25 s later on cables that do not stretch.

    rests: in the stretch from 10 to 18 s of the frames the last joint hardly moves."""
    rng, time = np.random.default_rng(seed), np.arange(-2, 43, 2e-3)
    speed = gaussian_filter1d(rng.normal(size=(len(time), ARM.N)), 120, axis=0)
    speed /= speed.std(axis=0)
    if rests:
        speed[(time > 9) & (time < 20), -1] *= 0.02
    alpha = np.cumsum(speed - speed.mean(axis=0), axis=0) * 2e-3
    alpha = 0.25 * (alpha - alpha.mean(axis=0)) / alpha.std(axis=0)
    theta = (lengths(ARM, np.zeros(ARM.N)) - lengths(ARM, alpha)) / ARM.drum
    frames = np.arange(0, 40, 1 / 30)
    seen = np.stack([np.interp(frames, time, a) for a in alpha.T], axis=-1) + rng.normal(0, 3e-4, (len(frames), ARM.N))
    return frames, seen, time + SHIFT, theta


def part_of(time: np.ndarray, theta: np.ndarray, begin: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    inside = (time > begin) & (time < begin + seconds)
    return time[inside], theta[inside]


def speeds(time: np.ndarray, theta: np.ndarray) -> CableSpeeds:
    return cable_speeds(time, ARM.drum * theta)


@pytest.mark.parametrize("begin", [2.0, 8.0, 14.0, 20.0, 26.0, 32.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_log_of_six_seconds_is_found_in_forty_of_frames(seed: int, begin: float) -> None:
    """Less than a fifth of all motion: shifts at which no more than that overlaps were passed over, and the true one with them."""
    frames, alpha, time, theta = film_and_log(seed)
    video = cable_speeds(frames, cable_winding(ARM, alpha))
    found = align_coarsely(video, speeds(*part_of(time, theta, begin, 6.0)))
    assert found.shift == pytest.approx(SHIFT, abs=0.02)
    assert found.correlation > 0.99


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_cable_that_rests_where_the_log_is_contradicts_no_other(seed: int) -> None:
    frames, alpha, time, theta = film_and_log(seed, rests=True)
    video, log = cable_speeds(frames, cable_winding(ARM, alpha)), speeds(*part_of(time, theta, 11.5, 7.0))
    check_labels(ARM, frames, alpha, video, log, align_coarsely(video, log))


@pytest.mark.parametrize("order", [(1, 0, 2, 3), (1, 0, 3, 2)])
def test_an_exchange_is_named_in_a_log_of_half_the_frames(order: tuple[int, ...]) -> None:
    """It was called another recording, as half of the video has nothing to go with."""
    frames, alpha, time, theta = film_and_log(4)
    video, log = cable_speeds(frames, cable_winding(ARM, alpha)), speeds(*part_of(time, theta[:, order], 8.0, 20.0))
    with pytest.raises(Refused, match=r"theta1 and theta2 are swapped|another order: theta2 is motor 1's"):
        check_labels(ARM, frames, alpha, video, log, align_coarsely(video, log))


@pytest.mark.parametrize("seconds", [1.5, 3.0, 4.5])
def test_what_is_too_short_is_said_to_be_that_and_nothing_else(seconds: float) -> None:
    """Of three seconds motors were called swapped, the picture mirrored, and the camera's rate another one."""
    frames, alpha, time, theta = film_and_log(5)
    angles = Angles(frames, alpha, np.full(alpha.shape, 3e-4))
    for begin in (3.0, 11.0, 19.0):
        at, short = part_of(time, theta, begin, seconds)
        log = Series(at, numbered_columns("theta", short))
        assert check_log_meaning(NECK, ARM, angles, log) == ()
        with pytest.raises(Refused, match=r"the log is .* s long.*5 s are needed"):
            fit_clock(ARM, angles, log)


@pytest.mark.parametrize("blocks", [6, 10, 40])
def test_sigmas_of_a_regression_hold_in_few_blocks(blocks: int) -> None:
    """Errors and columns that last half a block: of few blocks the spread is not known well either, as Student says."""
    z = []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        time = np.arange(0, blocks, 0.04)
        columns = gaussian_filter1d(rng.normal(size=(len(time), 4)), 12, axis=0)
        columns = np.column_stack([columns / columns.std(axis=0), np.ones(len(time))])
        error = gaussian_filter1d(rng.normal(size=len(time)), 5)
        values = columns @ np.array([1.0, 0.5, -0.3, 0.2, 2.0]) + 0.1 * error / error.std()
        coefficients, sigma, *_ = log_regression._least_squares(columns, values, time)
        z.append((coefficients[0] - 1.0) / sigma[0])
    expected = 2 * student.cdf(2.0, blocks / 2) - 1
    assert np.mean(np.abs(z) < 2) > expected - 2.6 * np.sqrt(expected * (1 - expected) / 300)
    assert np.median(np.abs(z)) > 0.3  # and not by being anything


@pytest.mark.parametrize(
    ("unexplained", "says"),
    [
        (0.01, r"f2 has the wrong sign.*write motors\[1\].f_scale: -1"),
        (0.43, r"leave 43 % of cable 2's way unexplained.*is cables\[1\].route in neck.yaml as the cable runs"),
    ],
)
def test_a_cable_that_runs_otherwise_is_no_force_of_the_wrong_sign(
    unexplained: float, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its sign was to be turned, and then to be turned back."""
    factors = Factors(np.ones(4), np.full(4, 0.05), 0.9, 1e-3)
    monkeypatch.setattr(force_plausibility, "force_factors", lambda arm, motion: factors)
    shares = np.array([0.01, unexplained, 0.005, 0.01])
    with pytest.raises(Refused, match=says):
        check_forces(NECK, ARM, cast("Any", None), np.array([-90.0, 6.5, -130.0, -20.0]), shares)
