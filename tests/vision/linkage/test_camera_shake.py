"""A camera that turns a little from frame to frame, before an arm whose corners another geometry and camera model place."""

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
import pytest

from mechanism.description import read_neck
from samples.generator.camera import SAMPLE_CAMERA
from tests.paths import ROOT
from tests.vision.linkage.test_row_time import swinging
from tests.vision.scene import corners
from tests.vision.test_extract import CAMERA, tracks_of_corners
from vision.extract import Extraction, ExtractionOptions, extract
from vision.linkage.linkage_fit import fit_linkage
from vision.video import describe_video

R = ROOT / "samples" / "recording"
NECK = read_neck(R / "neck.yaml")
TIME = np.arange(300) / 30
CORNER_PX, MARKER_PX, SHAKE_PX = 0.03, 0.02, 0.14
"""px: noise of single corners, of whole markers, and rms motion of the picture along its rows, and along its columns"""
Course = Callable[[np.ndarray], np.ndarray]
"""from times (F,), s, to motions of the picture (F, 2) of mean square one"""


def sines(hertz: float, seed: int) -> Course:
    phase = np.random.default_rng([seed, 7]).uniform(0, 2 * np.pi, 2)
    return lambda t: np.sqrt(2) * np.sin(2 * np.pi * hertz * t[:, None] + phase)


def wandering(seed: int) -> Course:
    """Slower than the arm moves: ten sines below .25 Hz."""
    rng = np.random.default_rng([seed, 8])
    hertz, phase, size = rng.uniform(0.02, 0.25, 10), rng.uniform(0, 2 * np.pi, (10, 2)), rng.normal(size=(10, 2))
    size /= np.sqrt(np.sum(size**2, axis=0) / 2)
    return lambda t: np.sum(size * np.sin(2 * np.pi * hertz[:, None] * t[:, None, None] + phase), axis=1)


def knocked(seed: int) -> Course:
    """Struck at 4 s, it swings for half a second."""
    way = np.random.default_rng([seed, 9]).uniform(2, 5, 2)
    late = TIME[:, None] - 4
    return lambda t: np.where(late < 0, 0.0, way * np.exp(-np.abs(late) / 0.5) * np.cos(2 * np.pi * 5 * late))


def filmed(seed: int, course: Course | None, size_px: float = SHAKE_PX, roll: float = 0.0) -> np.ndarray:
    """Corners of a swinging arm, (F, markers, 4, 2), px; roll: turn about the optical axis over that about the others, rms."""
    rng = np.random.default_rng([seed, 3])
    alpha = swinging(seed)(TIME)
    assert NECK.markers is not None
    depth = rng.uniform(-0.008, 0.008, len(NECK.markers.on_bars))
    seen = corners(NECK, alpha, depth=depth)
    if course is not None:
        turn = size_px / SAMPLE_CAMERA.fx * course(TIME)
        still = cv2.Rodrigues(np.array(SAMPLE_CAMERA.rotation))[0]
        place = np.array(SAMPLE_CAMERA.translation)
        for k, (x, y) in enumerate(turn):
            turned = cv2.Rodrigues(np.array([-y, x, roll * (x - y)]))[0]
            rotation = tuple(cv2.Rodrigues(turned @ still)[0].ravel().tolist())
            moved = replace(SAMPLE_CAMERA, rotation=rotation, translation=tuple((turned @ place).tolist()))
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr("tests.vision.scene.SAMPLE_CAMERA", moved)
                seen[k] = corners(NECK, alpha[k : k + 1], depth=depth)[0]
    seen = seen + rng.normal(0, MARKER_PX, (*seen.shape[:2], 1, 2))
    return seen + rng.normal(0, CORNER_PX, seen.shape)


def extracted(seen: np.ndarray) -> Extraction:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vision.extract.track_video", lambda *args: tracks_of_corners(TIME, seen))
        return extract(describe_video(R / "video.mp4"), CAMERA, NECK, ExtractionOptions(template=False))


def errors(extraction: Extraction, seed: int) -> np.ndarray:
    """(F, N), rad."""
    return extraction.angles.alpha - swinging(seed)(TIME)


@pytest.mark.parametrize(
    ("shake", "seed"),
    [
        (lambda s: sines(0.4, s), 11),
        (lambda s: sines(2.0, s), 12),
        (lambda s: sines(8.0, s), 11),
        (wandering, 12),
        (knocked, 11),
    ],
)
def test_a_shake_is_named_and_hardly_reaches_the_angles(shake: Callable[[int], Course], seed: int) -> None:
    """Angles err by less than 1.6 times what they do before a camera that stands, and sigma holds it."""
    extraction = extracted(filmed(seed, shake(seed)))
    found = extraction.as_json()["shake"]
    rms = SHAKE_PX * np.sqrt(np.mean(shake(seed)(TIME) ** 2, axis=0))
    np.testing.assert_allclose(found["rms_px"], rms, rtol=0.2)
    assert found["sentence"] in extraction.as_json()["warnings"]
    error = errors(extraction, seed)
    still = errors(extracted(filmed(seed, None)), seed)
    assert np.all(np.sqrt(np.mean(error**2, axis=0)) < 1.6 * np.sqrt(np.mean(still**2, axis=0)) + np.radians(0.01))
    z = np.sqrt(np.mean((error / extraction.angles.sigma) ** 2, axis=0))
    assert np.all((z > 0.5) & (z < 1.35)), z


@pytest.mark.parametrize("seed", [13, 14])
def test_a_camera_that_stands_does_not_shake(seed: int) -> None:
    extraction = extracted(filmed(seed, None))
    assert extraction.fit.shake is None
    assert extraction.as_json()["shake"] is None
    assert extraction.as_json()["warnings"] == []


@pytest.mark.parametrize("seed", [16, 17])
def test_a_base_marker_that_alone_seems_to_move_is_no_shake(seed: int) -> None:
    """As under a shadow, or as a codec draws it: the other markers do not follow, and angles stay what they were."""
    seen = filmed(seed, None)
    quiet = errors(extracted(seen), seed)
    seen[:, 0] += SHAKE_PX * sines(0.4, seed)(TIME)[:, None]
    extraction = extracted(seen)
    assert extraction.fit.shake is not None
    assert abs(extraction.fit.shake.followed) < 0.3
    assert extraction.as_json()["shake"] is None
    assert np.sqrt(np.mean(errors(extraction, seed)[:, 1:] ** 2)) < 1.2 * np.sqrt(np.mean(quiet[:, 1:] ** 2))


def test_frames_that_do_not_show_the_base_have_a_larger_sigma() -> None:
    """The base is hidden for .6 s of every 2 s: a slow shake is followed from one side to the other, a fast one is not."""
    hidden = TIME % 2 > 1.4
    for hertz in (0.4, 8.0):
        seen = filmed(19, sines(hertz, 19))
        seen[hidden, 0] = np.nan
        extraction = extracted(seen)
        assert extraction.as_json()["shake"] is not None
        z = errors(extraction, 19) / extraction.angles.sigma
        assert 0.5 < np.sqrt(np.mean(z[hidden] ** 2)) < 1.3
        sigma = extraction.angles.sigma[:, 0]
        assert np.median(sigma[hidden]) > 1.3 * np.median(sigma[~hidden])


def test_a_slow_drift_is_a_drift_and_no_shake() -> None:
    """A turn by half a pixel over the recording."""
    drifting = filmed(20, lambda t: np.outer(t / t[-1], [0.8, 0.6]), 0.6)
    extraction = extracted(drifting)
    assert [d["kind"] for d in extraction.as_json()["drift"]] == ["ramp"]
    assert extraction.as_json()["shake"] is None


def test_a_turn_about_the_optical_axis_as_small_as_the_others_does_no_harm() -> None:
    extraction = extracted(filmed(21, sines(0.9, 21), roll=1.0))
    z = errors(extraction, 21) / extraction.angles.sigma
    assert np.all(np.sqrt(np.mean(z**2, axis=0)) < 1.3)


def test_what_the_other_markers_follow_is_told_with_its_sigma() -> None:
    """Base and others move by one shake, the base by a second one of its own as large: the others follow half of it."""
    followed, z = [], []
    for seed in range(30, 38):
        seen = filmed(seed, sines(1.7, seed))
        seen[:, 0] += SHAKE_PX * sines(2.3, seed + 100)(TIME)[:, None]
        shake = fit_linkage(NECK, CAMERA, seen, "test").shake
        assert shake is not None
        followed.append(shake.followed)
        z.append((shake.followed - 0.5) / shake.sigma)
    assert np.mean(followed) == pytest.approx(0.5, abs=0.08)
    assert 0.4 < np.sqrt(np.mean(np.square(z))) < 1.8
