"""What a motion that is designed takes for granted of the camera."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.deciding_motion import _angle_noise
from identification.dataset.series import Series, numbered_columns


def filmed(hertz: float, sigma: float) -> Any:
    """Two seconds of two joints, of which a frame is missing and another could not be read."""
    time = np.delete(np.arange(round(2 * hertz)) / hertz, 7)
    sigmas = np.full((len(time), 2), sigma)
    sigmas[5] = np.nan
    return SimpleNamespace(angles=Series(time, numbered_columns("sigma", sigmas)))


def test_frames_come_as_often_as_those_of_the_recordings_and_are_as_good() -> None:
    """Two recordings at 30 frames a second, and one with better frames at 50."""
    noise = _angle_noise([filmed(30.0, 2e-3), filmed(50.0, 1e-3), filmed(30.0, 2e-3)])
    assert noise.frame_hz == pytest.approx(30.0)
    assert noise.sigma == pytest.approx(2e-3)
