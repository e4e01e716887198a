"""Angles from marker corners that another construction of the linkage and another camera model placed."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from calibration.camera import Camera, camera_from
from mechanism.arm import arm_of
from mechanism.description import Neck, read_neck
from mechanism.printed_markers import BarMarker
from samples.generator.camera import SAMPLE_CAMERA
from tests.paths import NECK_FILE
from tests.vision.scene import NOISE_PX, corners
from vision.linkage.linkage_fit import fit_linkage
from vision.linkage.scene import Scene, SharedParameters, rotation_matrices
from vision.linkage.shared_fit import LinkageOptions
from xneck_foundation.errors import Refused

NECK = read_neck(NECK_FILE)


def camera() -> Camera:
    c = SAMPLE_CAMERA
    return camera_from(np.array([c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3]), (c.width, c.height))


def motion(frames: int) -> np.ndarray:
    t = np.arange(frames) / 30
    return 0.5 * np.sin(2 * np.pi * np.outer(t, [0.31, 0.47, 0.73]) + [0.0, 1.0, 2.0])


def with_markers(places: list[dict[str, Any]]) -> Neck:
    """The sample's arm with markers at the middles of other bars."""
    assert NECK.markers is not None
    on_bars = tuple(BarMarker(id=i, **place) for i, place in enumerate(places))
    return NECK.model_copy(update={"markers": NECK.markers.model_copy(update={"on_bars": on_bars})})


def test_exact_corners_give_exact_angles_and_pose() -> None:
    alpha = motion(120)
    fit = fit_linkage(NECK, camera(), corners(NECK, alpha), "test")
    assert np.max(np.abs(fit.alpha - alpha)) < 1e-7
    np.testing.assert_allclose(fit.tvec, SAMPLE_CAMERA.translation, atol=1e-7)


def test_error_over_sigma_has_spread_one() -> None:
    """10 seeds of 60 frames: spread of z within 0.9 and 1.1 (600 frames scatter it by 0.02, the common pose by 0.05)."""
    alpha = motion(60)
    z = []
    for seed in range(10):
        fit = fit_linkage(NECK, camera(), corners(NECK, alpha, seed), "test")
        error = fit.alpha - alpha
        z.append(np.einsum("fi,fij,fj->f", error, np.linalg.inv(fit.covariance), error) / 3)
        assert abs(fit.corner_sigma_px / NOISE_PX - 1) < 0.1
    assert 0.9 < np.sqrt(np.mean(z)) < 1.1


def test_a_hidden_marker_does_not_cost_its_angle_where_its_neighbours_determine_it() -> None:
    alpha = motion(90)
    seen = corners(NECK, alpha, 0)
    seen[30:50, 2] = np.nan
    fit = fit_linkage(NECK, camera(), seen, "test")
    assert np.isfinite(fit.alpha).all()
    assert np.max(np.abs(fit.alpha - alpha)[30:50]) < np.radians(1.0)


def test_angles_that_nothing_determines_are_not_invented() -> None:
    """Without the tip's marker its angle is unknown, the others are not; a frame without markers has none."""
    alpha = motion(90)
    seen = corners(NECK, alpha, 0)
    seen[10:20, 3] = np.nan
    seen[40:45] = np.nan
    fit = fit_linkage(NECK, camera(), seen, "test")
    assert np.isnan(fit.alpha[10:20, 2]).all()
    assert np.max(np.abs(fit.alpha - alpha)[10:20, :2]) < np.radians(0.5)
    assert np.isnan(fit.alpha[40:45]).all()
    assert np.isfinite(np.delete(fit.alpha, [*range(10, 20), *range(40, 45)], axis=0)).all()


def test_a_wrong_corner_is_confessed_by_its_frame() -> None:
    """One marker's corners 15 px off in one frame: that frame's sigma grows by ten, the others' do not change."""
    alpha = motion(60)
    clean = corners(NECK, alpha, 0)
    spoilt = clean.copy()
    spoilt[25, 1] += 15.0
    a = fit_linkage(NECK, camera(), clean, "test").covariance[:, 0, 0] ** 0.5
    b = fit_linkage(NECK, camera(), spoilt, "test").covariance[:, 0, 0] ** 0.5
    assert b[25] > 10 * a[25]
    assert np.max(np.abs(np.delete(b / a, 25) - 1)) < 0.2


def test_markers_turned_and_set_aside_as_the_description_says() -> None:
    assert NECK.markers is not None
    moved = tuple(
        marker.model_copy(update={"at": (0.004 * k, -0.003), "angle": 0.3 * k})
        for k, marker in enumerate(NECK.markers.on_bars)
    )
    neck = NECK.model_copy(update={"markers": NECK.markers.model_copy(update={"on_bars": moved})})
    alpha = motion(60)
    fit = fit_linkage(neck, camera(), corners(neck, alpha), "test")
    assert np.max(np.abs(fit.alpha - alpha)) < 1e-7


def test_without_the_base_marker_the_angles_have_no_reference() -> None:
    assert NECK.markers is not None
    others = NECK.markers.model_copy(update={"on_bars": NECK.markers.on_bars[1:]})
    neck = NECK.model_copy(update={"markers": others})
    with pytest.raises(Refused, match="base bar"):
        fit_linkage(neck, camera(), corners(neck, motion(40)), "test")
    hidden = corners(NECK, motion(40))
    hidden[:, 0] = np.nan
    with pytest.raises(Refused, match="found in no frame"):
        fit_linkage(NECK, camera(), hidden, "test")


def test_a_camera_that_ignores_its_lens_is_wrong_and_its_residuals_tell() -> None:
    """Negative control: exact corners through a camera without its distortion put angles off by a tenth of a degree."""
    alpha = motion(60)
    fit = fit_linkage(NECK, replace(camera(), distortion=np.zeros(5)), corners(NECK, alpha), "test")
    assert np.max(np.abs(fit.alpha - alpha)) > np.radians(0.1)
    assert fit.corner_sigma_px > 0.1


def test_markers_on_diagonals_stand_for_the_bars() -> None:
    """Exact corners of a base marker and of one diagonal a mechanism; another arm has both kinds of bars, two a bar."""
    alpha = motion(90)
    for places in (
        [{"bar": 0}, {"diagonal": "A1"}, {"diagonal": "B2"}, {"diagonal": "A3", "angle": 1.2, "at": (0.01, 0.004)}],
        [{"bar": 0}, {"bar": 0, "at": (0.02, 0.0)}, {"bar": 2}, {"bar": 3}, {"diagonal": "B1"}, {"diagonal": "A2"}],
    ):
        neck = with_markers(places)
        fit = fit_linkage(neck, camera(), corners(neck, alpha), "test")
        assert np.max(np.abs(fit.alpha - alpha)) < 1e-7


def unequal_noise(neck: Neck, alpha: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners whose noise is correlated and differs twentyfold between markers, with its covariance."""
    rng = np.random.default_rng(seed)
    seen = corners(neck, alpha)
    root = 0.03 * rng.normal(0, 1, (*seen.shape[:2], 8, 8)) * 20 ** rng.uniform(-0.5, 0.5, (*seen.shape[:2], 1, 1))
    noise = (root @ rng.normal(0, 1, (*seen.shape[:2], 8, 1))).reshape(seen.shape)
    return seen + noise, root @ np.swapaxes(root, -1, -2)


def test_stated_covariances_weigh_and_their_scale_is_found() -> None:
    """Covariances three times too small: the scale says 3, z is still one, and the angles gain over equal weights."""
    neck = with_markers([{"bar": 0}, {"bar": 1}, {"bar": 2}, {"bar": 3}, {"diagonal": "A2"}])
    alpha = motion(60)
    z, weighed, equal = [], [], []
    for seed in range(6):
        seen, covariance = unequal_noise(neck, alpha, seed)
        fit = fit_linkage(neck, camera(), seen, "test", covariance=covariance / 9)
        error = fit.alpha - alpha
        z.append(np.einsum("fi,fij,fj->f", error, np.linalg.inv(fit.covariance), error) / 3)
        assert abs(fit.scale / 3 - 1) < 0.1
        weighed.append(error)
        equal.append(fit_linkage(neck, camera(), seen, "test").alpha - alpha)
    assert 0.9 < np.sqrt(np.mean(z)) < 1.1
    assert np.sqrt(np.mean(np.square(weighed))) < 0.5 * np.sqrt(np.mean(np.square(equal)))


def test_single_covariances_may_be_missing_or_of_lower_rank() -> None:
    """A refinement of four degrees of freedom states a singular covariance; where it failed, NaN."""
    alpha = motion(60)
    covariance = np.broadcast_to(np.eye(8), (60, 4, 8, 8)).copy()
    covariance[10:20, 1] = np.nan
    covariance[:, 2] = np.diag([1.0] * 4 + [0.0] * 4)
    fit = fit_linkage(NECK, camera(), corners(NECK, alpha), "test", covariance=covariance)
    assert np.max(np.abs(fit.alpha - alpha)) < 1e-7
    assert np.isfinite(fit.covariance).all()


def test_derivatives_by_all_that_frames_share() -> None:
    """The assembled Jacobian against a step of the whole vector in a random direction; rotations against OpenCV's."""
    rng = np.random.default_rng(4)
    neck = with_markers([{"bar": 0}, {"bar": 2}, {"diagonal": "B3"}])
    assert neck.markers is not None
    scene = Scene(arm_of(neck), neck.markers, free_lengths=True)
    pose = np.array([*SAMPLE_CAMERA.rotation, *SAMPLE_CAMERA.translation])
    drift = rng.normal(0, 0.01, (2, 6))
    shared = SharedParameters(pose, rng.normal(0, 0.003, (3, 6)), np.stack([scene.arm.L, scene.arm.b]), drift)
    alpha, course, way = rng.normal(0, 0.3, (5, 3)), rng.uniform(0, 1, (5, 2)), rng.normal(0, 1, len(shared.vector))
    h = 1e-6
    ahead, behind = (scene.image(shared.plus(s * h * way), alpha, course) for s in (1, -1))
    np.testing.assert_allclose(
        scene.by_shared(shared, alpha, course) @ way, (ahead - behind) / (2 * h), rtol=1e-6, atol=1e-8
    )
    for vector in (np.zeros(3), pose[:3], np.array([2.9, 1.9, -0.4])):
        np.testing.assert_allclose(rotation_matrices(vector), cv2.Rodrigues(vector)[0], atol=1e-12)


def test_offsets_that_last_for_the_whole_recording_are_in_the_common_error() -> None:
    """Corners displaced by 0.015 px for good, 0.02 px of noise a frame, 12 seeds: the mean error over the recording has z of
    0.7 to 1.3 when such offsets are expected; taken to be none it is over 4 times what sigma says."""
    alpha = motion(150)
    exact = corners(NECK, alpha)
    z: dict[float, list[np.ndarray]] = {0.0: [], 0.015: []}
    for seed in range(12):
        rng = np.random.default_rng(seed)
        seen = exact + rng.normal(0, 0.02, exact.shape) + rng.normal(0, 0.015, exact.shape[1:])
        for expected in z:
            fit = fit_linkage(NECK, camera(), seen, "test", options=LinkageOptions(drift=False, systematic_px=expected))
            assert fit.noise is not None
            common = np.diagonal((fit.covariance - fit.noise).mean(axis=0))
            z[expected].append((fit.alpha - alpha).mean(axis=0) / np.sqrt(common))
    spread = {expected: float(np.sqrt(np.mean(np.square(values)))) for expected, values in z.items()}
    assert 0.7 < spread[0.015] < 1.3
    assert spread[0.0] > 4
