"""A tripod that was knocked, one that sinks, and one that stands."""

from dataclasses import replace

import numpy as np
import pytest

from mechanism.description import Neck
from samples.generator.camera import SAMPLE_CAMERA
from tests.vision.linkage.test_linkage_fit import NECK, camera
from tests.vision.linkage.test_marker_placement import motion, wrong
from tests.vision.scene import NOISE_PX, corners
from vision.linkage.linkage_fit import fit_linkage
from vision.linkage.shared_fit import LinkageOptions, PlacementPrior

KNOCK = np.array([0.008, 0.005, 0.002])  # rad


def moved(neck: Neck, alpha: np.ndarray, share: np.ndarray, seed: int, turn: np.ndarray) -> tuple[np.ndarray, float]:
    """Corners as the camera turns by `share`, (F,), of `turn`; and by how many pixels all of it moves them, RMS."""
    still = corners(neck, alpha)
    x, y, z = (np.array(SAMPLE_CAMERA.rotation) + turn).tolist()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tests.vision.scene.SAMPLE_CAMERA", replace(SAMPLE_CAMERA, rotation=(x, y, z)))
        shift = corners(neck, alpha) - still
    noise = np.random.default_rng(seed).normal(0, NOISE_PX, still.shape)
    return still + share[:, None, None, None] * shift + noise, float(np.sqrt(np.mean(np.sum(shift**2, axis=-1))))


@pytest.mark.parametrize("placement", [None, PlacementPrior()])
def test_a_knock_is_found_at_its_frame_with_its_size_and_does_not_reach_the_angles(
    placement: PlacementPrior | None,
) -> None:
    alpha = motion(900, 30.0, 1)
    time = 5 + np.arange(900) / 30
    seen, size = moved(NECK, alpha, (np.arange(900) >= 372).astype(float), 1, KNOCK)
    fit = fit_linkage(NECK, camera(), seen, "test", time=time, options=LinkageOptions(placement))
    (knock,) = fit.drift
    assert (knock.kind, knock.frame, knock.time) == ("step", 372, time[372])
    assert size > 1
    assert abs(knock.size_px - size) < 4 * knock.sigma_px + 0.02 * size  # its mean over all frames, not over 50
    assert abs(fit.corner_sigma_px / NOISE_PX - 1) < 0.02
    assert f"{time[372]:.1f} s" in fit.notes["drift"][0]["sentence"]
    # what differs from frame to frame is noise only, on both sides of the knock
    assert fit.noise is not None
    error = fit.alpha - alpha - np.mean(fit.alpha - alpha, axis=0)
    z = np.einsum("fi,fij,fj->f", error, np.linalg.inv(fit.noise), error) / 3
    assert 0.9 < np.mean(z) < 1.1
    ignored = fit_linkage(NECK, camera(), seen, "test", options=LinkageOptions(drift=False))
    assert np.max(np.abs(np.mean((ignored.alpha - alpha)[:372], axis=0))) > np.radians(0.2)


def test_a_tripod_that_sinks_slowly_is_a_ramp() -> None:
    alpha = motion(900, 30.0, 2)
    seen, size = moved(NECK, alpha, np.linspace(0, 1, 900), 2, KNOCK)
    fit = fit_linkage(NECK, camera(), seen, "test")
    (sinking,) = fit.drift
    assert sinking.kind == "ramp"
    assert abs(sinking.size_px / size - 1) < 0.05
    assert fit.poses is not None
    assert np.max(np.abs(fit.alpha - alpha)) < np.radians(0.3)


@pytest.mark.parametrize("kind", ["step", "ramp"])
def test_a_focus_that_breathes_is_a_change_of_scale_and_a_turn_is_none(kind: str) -> None:
    """Pixels are scaled about the principal point, which is what a longer focal length does and no motion of a camera exactly."""
    alpha = motion(600, 30.0, 3)
    share = np.linspace(0, 1, 600) if kind == "ramp" else (np.arange(600) >= 250).astype(float)
    still = corners(NECK, alpha)
    middle = np.array([SAMPLE_CAMERA.cx, SAMPLE_CAMERA.cy])
    seen = middle + (1 + 0.004 * share)[:, None, None, None] * (still - middle)
    seen = seen + np.random.default_rng(3).normal(0, NOISE_PX, seen.shape)
    fit = fit_linkage(NECK, camera(), seen, "test")
    (breath,) = fit.drift
    assert breath.kind == kind
    assert breath.scale is not None
    assert abs(breath.scale - 0.004) < 0.0004
    assert "scale" in breath.sentence
    assert np.max(np.abs(np.mean(fit.alpha - alpha, axis=0))) < np.radians(0.1)
    turned, _ = moved(NECK, alpha, share, 3, KNOCK)
    (turn,) = fit_linkage(NECK, camera(), turned, "test").drift
    assert turn.scale is None
    assert "scale" not in turn.sentence


def test_a_camera_that_stands_is_not_suspected() -> None:
    """Negative control: none of 20 recordings (in 20, a rate of one in twenty would show one in 64 % of all runs)."""
    for seed in range(20):
        alpha = motion(200, 30.0, seed)
        assert not fit_linkage(NECK, camera(), corners(NECK, alpha, seed), "test").drift


def test_what_lasts_from_key_frame_to_key_frame_is_no_motion_of_the_camera() -> None:
    """A codec's errors stay with each marker for 27 frames, as far as they do in small tags; in 2 s, 10 and 20."""
    for frames, seed in ((60, 1), (60, 2), (300, 105), (300, 111), (300, 114), (600, 6)):
        alpha, rng = motion(frames, 30.0, seed), np.random.default_rng(seed)
        seen = corners(NECK, alpha, seed)
        lasting = 0.05 * rng.normal(size=(frames // 27 + 1, *seen.shape[1:]))
        assert not fit_linkage(NECK, camera(), seen + lasting[np.arange(frames) // 27], "test").drift


def test_of_a_short_recording_a_knock_is_found_all_the_same() -> None:
    alpha = motion(90, 30.0, 1)
    seen, size = moved(NECK, alpha, (np.arange(90) >= 40).astype(float), 1, KNOCK)
    (knock,) = fit_linkage(NECK, camera(), seen, "test").drift
    assert (knock.kind, knock.frame) == ("step", 40)
    assert abs(knock.size_px / size - 1) < 0.1


def test_wrong_markers_that_are_believed_are_not_taken_for_a_camera_that_moved() -> None:
    for seed in range(4):
        alpha = motion(600, 30.0, seed)
        assert not fit_linkage(wrong(NECK, seed), camera(), corners(NECK, alpha, seed), "test").drift
