"""Motor angles from counts, at rates that loggers have."""

from dataclasses import replace

import numpy as np
import pytest

from identification.dataset.series import Series
from mechanism.arm import arm_of
from mechanism.description import read_neck
from state_estimation.motors import Motors, motors_of
from tests.paths import NECK_FILE

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


def speeds_with_friction(motors: Motors) -> np.ndarray:
    within = motors.with_friction(arm_of(read_neck(NECK_FILE)), np.full(4, 15.0), np.full(4, 0.1)).within_rows
    assert within is not None
    return within.mean


def test_forces_that_act_late_are_those_of_a_log_that_has_them_later() -> None:
    """10 ms late are five rows at 500 Hz; the first and the last half second have other rows beside them."""
    time, rate = np.arange(1500) / 500, np.array([3.0, 4.0, 5.0, 6.0])
    theta = 4 * np.sin(np.outer(time, rate))
    f = 60 + 30 * np.sign(np.cos(np.outer(time, rate))) + 10 * np.sin(np.outer(time, 7 * rate))
    columns = {f"{name}{j + 1}": values[:, j] for name, values in (("theta", theta), ("f", f)) for j in range(4)}
    late = motors_of(Series(time, columns), np.full(4, COUNT), delay=0.01)
    later = replace(late, f=np.concatenate([np.repeat(f[:1], 5, axis=0), f[:-5]]), delay=0.0)
    inner = slice(250, -250)
    expected = speeds_with_friction(later)[:, inner]
    np.testing.assert_allclose(speeds_with_friction(late)[:, inner], expected, atol=1e-6)
    assert np.abs(speeds_with_friction(replace(late, delay=0.0))[:, inner] - expected).max() > 0.1
