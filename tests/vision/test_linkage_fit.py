"""Angles from marker corners that another construction of the linkage and another camera model placed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibration.camera import Camera, camera_from
from mechanism.description import read_neck
from samples.generator.camera import SAMPLE_CAMERA
from tests.vision.scene import NOISE_PX, corners
from vision.linkage_fit import fit_linkage
from xneck.errors import Refused

NECK = read_neck(Path(__file__).parents[2] / "samples/recording/neck.yaml")


def camera() -> Camera:
    c = SAMPLE_CAMERA
    return camera_from(np.array([c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3]), (c.width, c.height))


def motion(frames: int) -> np.ndarray:
    t = np.arange(frames) / 30
    return 0.5 * np.sin(2 * np.pi * np.outer(t, [0.31, 0.47, 0.73]) + [0.0, 1.0, 2.0])


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
    with pytest.raises(Refused, match="never in view"):
        fit_linkage(NECK, camera(), hidden, "test")


def test_a_camera_that_ignores_its_lens_is_wrong_and_its_residuals_tell() -> None:
    """Negative control: exact corners through a camera without its distortion put angles off by a tenth of a degree."""
    alpha = motion(60)
    fit = fit_linkage(NECK, replace(camera(), distortion=np.zeros(5)), corners(NECK, alpha), "test")
    assert np.max(np.abs(fit.alpha - alpha)) > np.radians(0.1)
    assert fit.corner_sigma_px > 0.1
