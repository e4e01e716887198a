"""Sigma of the angles by offsets of corners that last, and where an angle is no measurement: judged from above and from below."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.vision.linkage.test_linkage_fit import NECK, camera
from tests.vision.linkage.test_marker_placement import motion
from tests.vision.scene import corners
from vision.linkage import linkage_fit, shared_fit
from vision.linkage.linkage_fit import fit_linkage
from vision.linkage.offset_sensitivity import OffsetSensitivity, offset_sensitivity
from vision.linkage.shared_fit import LinkageOptions

FRAMES = 60
OFFSET_PX = 0.05
ALONE = LinkageOptions(drift=False)


@pytest.mark.parametrize("axis", [0, 1])
def test_an_offset_of_the_whole_picture_moves_the_camera_and_no_angle(
    axis: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All corners of all markers are shifted alike: what that does to an angle directly, the camera's pose takes back. With a wrong
    sign between the two it would count twice."""
    directly: list[np.ndarray] = []

    def of_the_whole(*words: Any) -> OffsetSensitivity:
        one = offset_sensitivity(*words)
        alike = (np.arange(one.on_shared.shape[1]) % 2 == axis).astype(float)[:, None]
        directly.append((one.on_angles @ alike)[..., 0])
        return replace(one, on_angles=one.on_angles @ alike, on_shared=one.on_shared @ alike)

    seen = corners(NECK, motion(FRAMES, 2.0, 0), 0, 0.01)[::6]
    plain = fit_linkage(NECK, camera(), seen, "test", options=ALONE)
    for module in (linkage_fit, shared_fit):
        monkeypatch.setattr(module, "offset_sensitivity", of_the_whole)
    unsure = fit_linkage(NECK, camera(), seen, "test", options=replace(ALONE, systematic_px=OFFSET_PX))
    stated = np.sqrt(np.maximum(np.diagonal(unsure.covariance - plain.covariance, axis1=1, axis2=2), 0))
    focal = float(np.sqrt(camera().K[0, 0] * camera().K[1, 1]))
    alone = np.abs(directly[-1]) * OFFSET_PX / focal
    assert alone.max() > 4e-5
    assert stated.max() < 0.1 * alone.max()


def test_offsets_that_last_move_the_angles_as_their_sigma_says() -> None:
    """Each coordinate of each marker's corners is moved by one standard deviation in all frames, and everything fitted anew: the
    squares of what the angles do add up to what the covariance has more. An offset acts directly and by way of the camera's
    pose."""
    seen = corners(NECK, motion(FRAMES, 2.0, 0), 0, 0.01)[::6]
    plain = fit_linkage(NECK, camera(), seen, "test", options=ALONE)
    unsure = fit_linkage(NECK, camera(), seen, "test", options=replace(ALONE, systematic_px=OFFSET_PX))
    stated = np.diagonal(unsure.covariance - plain.covariance, axis1=1, axis2=2)
    moved = np.zeros_like(stated)
    for marker in range(seen.shape[1]):
        for corner in range(4):
            for axis in range(2):
                shifted = seen.copy()
                shifted[:, marker, corner, axis] += OFFSET_PX
                moved += (fit_linkage(NECK, camera(), shifted, "test", options=ALONE).alpha - plain.alpha) ** 2
    np.testing.assert_allclose(np.sqrt(stated), np.sqrt(moved), rtol=0.05)


def test_angles_are_left_out_from_three_degrees_on() -> None:
    """A marker that is ever less sure from frame to frame, up to where its bar's angle is anything: given where its sigma is below
    3 degrees, and NaN where it is above."""
    seen = corners(NECK, motion(FRAMES, 2.0, 0), 0, 0.02)
    covariance = np.broadcast_to(0.02**2 * np.eye(8), (FRAMES, seen.shape[1], 8, 8)).copy()
    spread = np.geomspace(1, 3e4, FRAMES)
    covariance[:, -1] *= spread[:, None, None] ** 2
    fit = fit_linkage(NECK, camera(), seen, "test", covariance=covariance, options=ALONE)
    assert fit.noise is not None
    sigma = np.degrees(np.sqrt(np.diagonal(fit.noise, axis1=1, axis2=2)))
    last = sigma[:, -1]
    assert np.any((last > 1.5) & (last < 3))
    assert np.any((last > 3) & (last < 6))
    np.testing.assert_array_equal(np.isnan(fit.alpha), sigma >= 3)
