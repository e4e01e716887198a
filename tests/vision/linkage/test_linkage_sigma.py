"""Sigma of the angles by offsets of corners that last, and where an angle is no measurement: judged from above and from below."""

from dataclasses import replace

import numpy as np

from tests.vision.linkage.test_linkage_fit import NECK, camera
from tests.vision.linkage.test_marker_placement import motion
from tests.vision.scene import corners
from vision.linkage.linkage_fit import fit_linkage
from vision.linkage.shared_fit import LinkageOptions

FRAMES = 60
OFFSET_PX = 0.05
ALONE = LinkageOptions(drift=False)


def test_offsets_that_last_move_the_angles_as_their_sigma_says() -> None:
    """Each coordinate of each marker's corners is moved by one standard deviation in all frames, and everything fitted anew: the
    squares of what the angles do add up to what the covariance has more. An offset acts directly and by way of the camera's
    pose; the two undo each other in part, so that with a wrong sign neither sum is near."""
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
