"""A rolling shutter's rows are brought to one moment; truth by a search for the moment at which each row saw its corner."""

import numpy as np

from mechanism.description import read_neck
from tests.paths import NECK_FILE
from tests.vision.scene import corners, rolled
from vision.shutter import Shutter, at_middle_row, velocity

NECK = read_neck(NECK_FILE)
ROW_S = 15e-6  # 11 ms for 720 rows
TIME = np.arange(120, dtype=float) / 30


def alpha(t: np.ndarray) -> np.ndarray:
    return 0.45 * np.sin(2 * np.pi * np.multiply.outer(t, [0.31, 0.47, 0.73]) + [0.0, 1.0, 2.0])


def test_rows_are_brought_to_one_moment() -> None:
    """Left alone corners are off by over 2 px; moved along their own motion by less than 0.05 px within the recording."""
    still, rolling = corners(NECK, alpha(TIME)), rolled(NECK, TIME, alpha, ROW_S)
    assert np.max(np.abs(rolling - still)) > 2.0
    mended = at_middle_row(TIME, rolling, 720, Shutter(row_s=ROW_S))
    assert np.max(np.abs(mended - still)[1:-1]) < 0.05
    wrong = at_middle_row(TIME, rolling, 720, Shutter(row_s=-ROW_S))
    assert np.max(np.abs(wrong - still)) > 4.0


def test_a_missing_frame_leaves_one_side() -> None:
    rolling = rolled(NECK, TIME, alpha, ROW_S)
    rolling[50] = np.nan
    mended = at_middle_row(TIME, rolling, 720, Shutter(row_s=ROW_S))
    assert np.isnan(mended[50]).all()
    assert np.max(np.abs(mended - corners(NECK, alpha(TIME)))[[49, 51]]) < 0.5


def test_stamps_mean_what_they_are_said_to_mean() -> None:
    shutter = {"exposure_s": 0.004, "row_s": 1e-5}
    for word, shift in (("start", 0.002 + 359.5e-5), ("middle", 0.0), ("end", -0.002 - 359.5e-5)):
        np.testing.assert_allclose(Shutter(**shutter, stamp=word).middle(TIME, 720) - TIME, shift, atol=1e-12)  # type: ignore[arg-type]


def test_velocity_is_exact_for_a_parabola_whatever_the_gaps() -> None:
    """Frames that were dropped leave uneven gaps, over which a slope weighted the wrong way round is off by the acceleration."""
    time = np.array([0.0, 1.0, 3.0, 4.0, 8.0]) / 30
    start, speed, acceleration = (np.random.default_rng(k).normal(0, 50, (1, 2, 4, 2)) for k in range(3))
    t = time[:, None, None, None]
    found = velocity(time, start + speed * t + acceleration * t**2 / 2)
    np.testing.assert_allclose(found[1:-1], (speed + acceleration * t)[1:-1], rtol=1e-9, atol=1e-9)
    # at the ends there is only the slope towards the neighbour: that of the middle between both
    np.testing.assert_allclose(found[0], (speed + acceleration * t[1] / 2)[0], rtol=1e-9)
    np.testing.assert_allclose(found[-1], (speed + acceleration * (t[-2] + t[-1]) / 2)[0], rtol=1e-9)
