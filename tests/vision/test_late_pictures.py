"""Single frames of another moment than their stamps are told from arms that stop, turn over and jerk, and by how much."""

import numpy as np
import pytest

from tests.paths import SAMPLES
from tests.vision.markers.test_tracking import NECK
from tests.vision.scene import corners
from vision.late_pictures import late_pictures

TRUTH = np.load(SAMPLES / "truth.npz")
TIME, ALPHA = TRUTH["recording_frame_times"], TRUTH["recording_frame_alpha"]
PERIOD_S = float(np.median(np.diff(TIME)))


def shown(late_s: np.ndarray, seed: int) -> np.ndarray:
    """Where markers are seen in frames that were taken so much before their stamps, with 0.05 px of noise."""
    at = TIME - late_s
    alpha = np.stack([np.interp(at, TIME, angle) for angle in ALPHA.T], axis=1)
    return corners(NECK, alpha, seed=seed)


def test_no_frame_of_a_recording_is_late() -> None:
    assert np.isnan(late_pictures(TIME, shown(np.zeros(len(TIME)), seed=3))).all()


@pytest.mark.parametrize("periods", [0.5, 1.0, -0.6])
def test_frames_in_motion_are_found_with_how_late_they_are(periods: float) -> None:
    late_s = np.zeros(len(TIME))
    late_s[np.arange(105, 700, 23)] = periods * PERIOD_S
    seen = shown(late_s, seed=4)
    moved = np.linalg.norm((seen - shown(0 * late_s, seed=4)).mean(axis=2), axis=-1)
    clear = np.sort(moved, axis=1)[:, -2] > 2
    found = late_pictures(TIME, seen)
    assert not np.isfinite(found[late_s == 0]).any()
    assert clear.sum() > 8
    # also where the arm slows down or turns over: there none was found, and angles were off by 60 sigmas
    assert np.isfinite(found[clear]).mean() > 0.9
    both = np.isfinite(found)
    np.testing.assert_allclose(found[both], late_s[both], atol=0.2 * PERIOD_S)


@pytest.mark.parametrize("deceleration", [1500.0, 4000.0, 10000.0])
@pytest.mark.parametrize("rest", [0.0, 0.1])
def test_an_arm_that_stops_between_two_frames_is_on_time(deceleration: float, rest: float) -> None:
    """At 300 px/s it is braked, rests, and is driven on the same way; without noise, which would hide it."""
    time = np.arange(60) / 30
    for phase in np.linspace(0, 1 / 30, 9):
        since, stopping = time - 1 - phase, 300.0 / deceleration
        braked = np.clip(since, 0, stopping)
        again = np.maximum(since - stopping - rest, 0)
        started = np.minimum(again, stopping)
        place = 300 * np.minimum(since, 0) + 300 * braked - deceleration * braked**2 / 2
        place = place + deceleration * started**2 / 2 + 300 * (again - started)
        places = np.zeros((60, 3, 4, 2))
        places[:, 1, :, 0], places[:, 2, :, 0] = place[:, None], 1.5 * place[:, None]
        assert np.isnan(late_pictures(time, places)).all()


def test_one_marker_alone_tells_nothing() -> None:
    late_s = np.zeros(len(TIME))
    late_s[np.arange(105, 700, 23)] = PERIOD_S
    seen = shown(late_s, seed=5)
    seen[:, :-1] = np.nan
    assert np.isnan(late_pictures(TIME, seen)).all()
    assert np.isnan(late_pictures(TIME[:3], seen[:3])).all()
