"""With which velocity a template is smeared: of a marker whose corners follow parabolas, at times that a camera skips."""

import numpy as np
import pytest

from mechanism.description import read_neck
from tests.paths import NECK_FILE
from vision.markers.tracking import MarkerTracker

TIMES = np.array([0.0, 1.0, 3.0, 4.0]) / 30
RNG = np.random.default_rng(0)
START, SPEED, ACCELERATION = (RNG.normal(0, size, (4, 4, 2)) for size in (100.0, 300.0, 4000.0))


def at(t: float) -> np.ndarray:
    return START + SPEED * t + ACCELERATION * t**2 / 2


def tracker(*times: float) -> MarkerTracker:
    markers = read_neck(NECK_FILE).markers
    assert markers is not None
    one = MarkerTracker(markers)
    one._past = [(t, at(t)) for t in times]
    return one


@pytest.mark.parametrize("last", [2, 3])
def test_velocity_of_a_parabola_is_its_slope_at_the_frame_itself(last: int) -> None:
    """The slope since the last frame is that of half a frame ago: at 4000 px/s^2 it is off by 67 px/s."""
    t = float(TIMES[last])
    found = tracker(*TIMES[last - 2 : last])._velocity(t, at(t))
    np.testing.assert_allclose(found, SPEED + ACCELERATION * t, rtol=1e-9)


def test_with_fewer_frames_it_is_that_of_a_line() -> None:
    t = float(TIMES[1])
    found = tracker(TIMES[0])._velocity(t, at(t))
    np.testing.assert_allclose(found, SPEED + ACCELERATION * t / 2, rtol=1e-9)
    assert np.isnan(tracker()._velocity(t, at(t))).all()


def test_a_marker_that_was_not_seen_two_frames_ago_has_the_slope_of_the_last() -> None:
    one = tracker(TIMES[1], TIMES[2])
    one._past[0][1][2] = np.nan
    t = float(TIMES[3])
    found = one._velocity(t, at(t))
    np.testing.assert_allclose(found[2], SPEED[2] + ACCELERATION[2] * (t + TIMES[2]) / 2, rtol=1e-9)
    np.testing.assert_allclose(found[0], SPEED[0] + ACCELERATION[0] * t, rtol=1e-9)


def test_a_prediction_is_the_parabola_carried_on() -> None:
    t = float(TIMES[3])
    np.testing.assert_allclose(tracker(*TIMES[:3])._predicted(t), at(t), rtol=1e-9)
