"""A camera's tone curve is found in one picture and costs nothing; pictures are those of `samples.generator.closeup`."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from benchmarks.marker_angle import in_plane_angle
from samples.generator.closeup import Flaws, picture, square
from vision.markers.photometric import MarkerStart, fit_markers
from vision.markers.template import Optics
from vision.markers.tone_curve import LINEAR, through_tone_curve
from vision.markers.tone_estimate import estimate_tone

SIZE = 96
AS_A_CAMERA_FOR_PEOPLE = Flaws(noise=1.0, black=12.0, white=200.0, ground=90.0, gamma=True)
LINEARLY = replace(AS_A_CAMERA_FOR_PEOPLE, gamma=False)
STILL = np.zeros((4, 2))


def cells_of(number: int) -> np.ndarray:
    """As OpenCV draws them, (8, 8), True is black."""
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36H11)
    return np.asarray(cv2.aruco.generateImageMarker(family, number, 8)) == 0


def shown(number: int, side: float, flaws: Flaws, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A picture and its true corners."""
    rng = np.random.default_rng([number, seed])
    corners = square(side, rng.uniform(-0.4, 0.4), np.full(2, SIZE / 2) + rng.uniform(-1, 1, 2))
    return picture(cells_of(number), corners, SIZE, flaws, rng), corners


def turned_by(side: float, tone: float | None) -> list[float]:
    """Mean error of the turn of four markers, rad; tone: as it is known, None where it is found in the first picture."""
    errors = []
    for number in (1, 3, 5, 8):
        found = []
        for seed in range(12):
            grey, corners = shown(number, side, AS_A_CAMERA_FOR_PEOPLE, seed)
            start = MarkerStart(corners + 0.3, cells_of(number), STILL)
            exponent = tone or estimate_tone(grey, [start], Optics())
            assert exponent is not None
            fit = fit_markers(grey, [start], Optics(tone=exponent))[0]
            assert not fit.fell_back
            found.append(in_plane_angle(fit.corners) - in_plane_angle(corners))
        errors.append(float(np.mean(found)))
    return errors


@pytest.mark.parametrize("side", [25.0, 42.0])
def test_the_curve_is_found_in_one_picture(side: float) -> None:
    """sRGB is near 1 / 2.2 with some light at its foot; a camera that writes light itself is told as such."""
    for number in (1, 5):
        for flaws, low, high in ((AS_A_CAMERA_FOR_PEOPLE, 0.34, 0.62), (LINEARLY, 0.9, 1.0)):
            grey, corners = shown(number, side, flaws, 7)
            tone = estimate_tone(grey, [MarkerStart(corners + 0.2, cells_of(number), STILL)], Optics())
            assert tone is not None
            assert low <= tone <= high


def test_without_it_markers_come_out_turned() -> None:
    """The curve's error is that of a marker's pattern, and more pictures do not lessen it."""
    wrong, right = (np.sqrt(np.mean(np.square(turned_by(42.0, tone)))) for tone in (LINEAR, None))
    assert right < 0.7 * wrong


def test_a_picture_without_a_clear_marker_tells_nothing() -> None:
    grey, corners = np.full((SIZE, SIZE), 90, dtype=np.uint8), square(42.0, 0.1, np.full(2, 48.0))
    assert estimate_tone(grey, [MarkerStart(corners, cells_of(1), STILL)], Optics()) is None
    assert estimate_tone(grey, [], Optics()) is None


def test_derivatives_are_those_of_the_value() -> None:
    """Against a difference of the value, with black and white where they were."""
    value = np.linspace(0.02, 0.98, 50)

    def through(v: np.ndarray) -> np.ndarray:
        channels = np.stack([v, np.ones_like(v), 2 * np.ones_like(v)]).astype(np.float32)
        return np.asarray(through_tone_curve(channels, 0.45), dtype=float)

    slope = (through(value + 1e-3)[0] - through(value - 1e-3)[0]) / 2e-3
    assert through(value)[1] == pytest.approx(slope, rel=0.01)
    assert through(value)[2] == pytest.approx(2 * slope, rel=0.01)
    assert through(np.array([0.0, 1.0]))[0] == pytest.approx([0.0, 1.0], abs=1e-6)
    unchanged = np.ones((5, 3), dtype=np.float32)
    assert through_tone_curve(unchanged, LINEAR) is unchanged
