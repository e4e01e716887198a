"""What is said of a camera that changed."""

import re

import numpy as np
import pytest

from calibration.camera import camera_from
from calibration.camera_check import _what_changed
from calibration.camera_comparison import CameraComparison


def test_how_far_directions_differ_is_said_in_pixels_and_degrees() -> None:
    """A focal length larger by 2 %: off by 0.02 r at r px from the axis; the picture is asked at a grid of points only."""
    camera = camera_from(np.array([620.0, 620.0, 319.5, 239.5, 0, 0, 0, 0, 0]), (640, 480))
    comparison = CameraComparison(camera, ("fx", "fy"), np.array([12.4, 12.4]), np.eye(2), 50.0)
    px = 0.02 * np.sqrt((640**2 + 480**2) / 12)
    found = _what_changed(camera, comparison)
    said = re.search(r"directions differ by (\S+) px or (\S+) deg", found.why)
    assert said is not None
    assert [float(number) for number in said.groups()] == pytest.approx([px, px / 620 * 180 / np.pi], rel=0.1)
    assert found.change_rad == pytest.approx(px / 620, rel=0.1)
