"""What errors that all frames share do to the state's sigma: each made dominant alone, on joints that swing as sines."""

import numpy as np
import pytest

from identification.dataset.frames import FrameAngles
from mechanism.arm import arm_of
from mechanism.description import read_neck
from state_estimation.motors import Motors
from state_estimation.state import estimate_state
from tests.paths import NECK_FILE

ARM = arm_of(read_neck(NECK_FILE))
TIME = np.arange(0, 20, 1 / 30)
AT = np.arange(1.0, 19.0, 0.002)
PULSE = 2 * np.pi * np.array([0.2, 0.3, 0.45])
PEAK = 0.4


def motion(t: np.ndarray, derivative: int) -> np.ndarray:
    phase = np.outer(t, PULSE) + np.array([0.0, 1.0, 2.0]) + derivative * np.pi / 2
    return PEAK * PULSE**derivative * np.sin(phase)


def sigma_beyond_noise(clock_sigma: tuple[float, float]) -> tuple[list[np.ndarray], np.ndarray]:
    """Of alpha, alpha', alpha'': what a clock's sigma adds to the noise's, in squares, (K, 3) each, and the times (K,)."""
    sigma = np.full((len(TIME), 3), 1e-4)
    frames = FrameAngles(TIME, motion(TIME, 0) + np.random.default_rng(0).normal(0, sigma), sigma, 0 * sigma)
    nothing: Motors = None  # type: ignore[assignment]
    unsure, sure = (estimate_state(ARM, frames, nothing, AT, clock, fuse=False) for clock in (clock_sigma, (0.0, 0.0)))
    added = np.diagonal(unsure.covariance - sure.covariance, axis1=1, axis2=2)
    return np.split(np.sqrt(np.maximum(added, 0)), 3, axis=1), unsure.covariance_time


@pytest.mark.parametrize(("offset", "skew"), [(5e-3, 0.0), (0.0, 1e-3), (3e-3, 5e-4)])
def test_a_clocks_sigma_moves_the_motion_along_itself(offset: float, skew: float) -> None:
    """A clock that is off by e shows alpha' e too much, alpha'' e of alpha', ...: of a skew e grows from the middle of the frames
    towards both ends. The motion is known, so what is added is known, from above and from below."""
    added, at = sigma_beyond_noise((offset, skew))
    error = np.hypot(offset, skew * (at - TIME.mean()))[:, None]
    for derivative, part in enumerate(added[:2]):
        expected = error * np.abs(motion(at, derivative + 1))
        if skew and derivative:  # the clock's rate scales speeds as well
            drift = skew * motion(at, 1)
            moved = skew * (at - TIME.mean())[:, None] * motion(at, 2)
            expected = np.sqrt((moved + drift) ** 2 + (offset * motion(at, 2)) ** 2)
        np.testing.assert_allclose(part, expected, atol=0.05 * expected.max())
    if skew:
        ends = np.abs(at - TIME.mean()) > 8
        assert np.sqrt(np.mean(added[0][ends] ** 2)) > 0.9 * skew * 8 * np.sqrt(np.mean(motion(at[ends], 1) ** 2))
