"""Motor angles from counts, at rates that loggers have."""

import numpy as np
import pytest

from identification.dataset.series import Series
from state_estimation.motors import motors_of

COUNT = 2 * np.pi / 2048


@pytest.mark.parametrize("log_hz", [50.0, 200.0, 500.0, 1000.0])
def test_motors_follow_a_reversal_within_their_sigma(log_hz: float) -> None:
    """Slow turns with 6 Hz on them: knots five rows apart, as dense logs have them, are 900 sigmas off at 50 Hz."""
    time = np.arange(0, 8, 1 / log_hz)
    theta = 10 * np.sin(2 * time) + 0.5 * np.sin(2 * np.pi * 6 * time)
    speed = 20 * np.cos(2 * time) + 6 * np.pi * np.cos(2 * np.pi * 6 * time)
    counted = np.round(theta / COUNT) * COUNT
    motors = motors_of(Series(time, {"theta1": counted, "f1": np.zeros_like(time)}), np.array([COUNT]))
    inner = slice(round(0.5 * log_hz), -round(0.5 * log_hz))
    assert motors.sigma is not None
    z = (motors.theta[:, 0] - theta)[inner] / motors.sigma[0][inner, 0]
    assert np.sqrt(np.mean(z**2)) < 1.5
    assert np.sqrt(np.mean((motors.theta_d[:, 0] - speed)[inner] ** 2)) < 0.5
