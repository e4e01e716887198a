"""A calibration that holds is left in peace; one that does not is caught, and what changed is named."""

import json
import re

import numpy as np
import pytest

from calibration.board import Chessboard
from calibration.camera import Camera, camera_from
from calibration.camera_check import check_camera
from calibration.corner_detection import BoardView
from calibration.estimation import calibrate
from calibration.observations import LeftOut, Observations
from tests.calibration.truth import CAMERA, SIZE, project, synthetic_views
from xneck_foundation.errors import Refused

CORNERS = Chessboard(kind="chessboard", columns=8, rows=6, square=0.025).corners
NOISE = 0.05  # px, what our corner finder leaves on rendered boards


def seen(
    rng: np.random.Generator, count: int = 10, size: tuple[int, int] = SIZE, noise_px: float = NOISE, **how
) -> Observations:
    return Observations(tuple(synthetic_views(rng, CORNERS, count, noise_px, **how)), (), size)


def calibrated(seed: int, **how) -> tuple[Camera, np.random.Generator]:
    rng = np.random.default_rng(seed)
    return calibrate(seen(rng, 15, **how)).camera, rng


@pytest.mark.parametrize("bow", [0.0, 0.0003], ids=["flat boards", "bowed boards"])
def test_the_same_camera_holds(bow: float):
    """20 of 20: the test is set to 1 false alarm in 1000, so that one in 20 would show a sigma that is far too small."""
    verdicts = []
    for seed in range(20):
        camera, rng = calibrated(seed, bow_m=bow)
        verdicts.append(check_camera(camera, seen(rng, 10, bow_m=bow)).verdict)
    assert verdicts == ["holds"] * 20


def test_it_needs_the_calibrations_own_sigma():
    """The control to the above: a camera taken for exact is found changed though it is not."""
    alarms = 0
    for seed in range(8):
        camera, rng = calibrated(seed, noise_px=0.3)
        exact = camera_from(camera.parameters, SIZE)
        found = check_camera(exact, seen(rng, 15))
        alarms += found.verdict == "does not hold"
        assert "no covariance" in found.notes[0]
    assert alarms >= 6


@pytest.mark.parametrize(
    ("moved", "says"),
    [
        ({0: 3.1, 1: 3.11}, r"focal length changed by \+0\.[456]"),  # 0.5 %
        ({2: 3.0}, r"principal point moved by [23]\.\d px"),
        ({3: -3.0}, r"principal point moved by [23]\.\d px"),
        ({0: 124.0, 1: 124.4}, r"focal length changed by \+20 %"),
        ({4: 0.03}, "distortion changed"),
        ({4: 0.21, 5: -0.07}, "distortion changed"),  # the camera began to correct it
    ],
)
def test_a_changed_camera_is_caught_and_the_change_named(moved: dict[int, float], says: str):
    now = CAMERA.copy()
    for index, step in moved.items():
        now[index] += step
    named = 0
    for seed in range(6):
        camera, rng = calibrated(100 + seed)
        found = check_camera(camera, seen(rng, 15, parameters=now))
        assert found.verdict == "does not hold"
        named += re.search(says, found.why) is not None
    assert named >= 5


def test_how_much_it_matters_is_how_much_directions_are_off():
    """A focal length larger by 2 %: the direction at r px from the axis is off by 0.02 r / f, less at a slant."""
    now = CAMERA.copy()
    now[:2] *= 1.02
    camera, rng = calibrated(7)
    found = check_camera(camera, seen(rng, 15, parameters=now))
    u, v = np.meshgrid(np.arange(640) - CAMERA[2], np.arange(480) - CAMERA[3])
    assert found.change_px == pytest.approx(0.02 * float(np.sqrt(np.mean(u**2 + v**2))), rel=0.1)
    assert found.change_px is not None
    assert found.change_rad == pytest.approx(found.change_px / 620, rel=0.02)


def test_another_resolution_is_caught_without_a_fit():
    camera, rng = calibrated(0)
    half = check_camera(camera, seen(rng, 8, size=(320, 240)))
    assert half.verdict == "does not hold"
    assert "320 x 240 px, the camera was calibrated at 640 x 480 (scaled by 0.5" in half.why
    assert "turned" in check_camera(camera, seen(rng, 8, size=(480, 640))).why


class TestCannotTell:
    def test_too_few(self):
        camera, rng = calibrated(0)
        found = check_camera(camera, seen(rng, 2))
        assert (found.verdict, found.rms_px) == ("cannot tell", None)
        assert "2 usable pictures" in found.why

    def test_no_tilt(self):
        camera, rng = calibrated(0, noise_px=0.1)
        loose = camera_from(camera.parameters, SIZE, covariance=100 * np.asarray(camera.covariance))
        found = check_camera(loose, seen(rng, 5, tilt_deg=1.0, noise_px=0.2))
        assert found.verdict == "cannot tell"
        assert "tilt the board" in found.why

    def test_a_gross_change_is_seen_even_without_tilt(self):
        """Lines that were straight are bent now, however the board is held."""
        now = CAMERA.copy()
        now[4:6] = 0.0
        camera, rng = calibrated(0)
        assert check_camera(camera, seen(rng, 5, tilt_deg=1.0, parameters=now)).verdict == "does not hold"


def test_one_bad_picture_is_left_out_and_named():
    camera, rng = calibrated(1)
    good = seen(rng, 9)
    spoiled = good.views[3].image_points + rng.normal(scale=2.0, size=(48, 2))
    bad = BoardView("spoiled", spoiled, CORNERS, np.arange(48))
    found = check_camera(camera, Observations((*good.views, bad), (LeftOut("x.png", "the board was not found"),), SIZE))
    assert found.verdict == "holds"
    assert [entry.name for entry in found.left_out] == ["x.png", "spoiled"]
    assert "spoiled" not in found.used
    json.dumps(found.as_json(), allow_nan=False)


def test_blurred_pictures_are_remarked():
    camera, rng = calibrated(2)
    found = check_camera(camera, seen(rng, 12, noise_px=0.4))
    assert "are they sharp" in found.notes[0]


def test_corners_that_are_not_finite():
    camera, _ = calibrated(3)
    R, t = np.eye(3), np.array([0.0, 0.0, 0.4])
    pixels = project(CORNERS, R, t)
    pixels[0, 0] = np.nan
    with pytest.raises(Refused, match="not finite"):
        check_camera(camera, Observations((BoardView("a", pixels, CORNERS, np.arange(48)),), (), SIZE))
