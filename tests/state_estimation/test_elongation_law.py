"""Regressors of the elongation: means over steps against fine integration, and what the law leaves of cables it should explain."""

from dataclasses import replace

import numpy as np
import pytest

from identification.dataset.series import Series, numbered_columns
from mechanism.arm import arm_of
from mechanism.description import read_neck
from mechanism.elasticity import elongation
from mechanism.friction import CM, dry
from samples.generator.laws import linear
from samples.generator.prescribed import World, prescribe
from state_estimation.elongation_law import law_of
from state_estimation.elongation_regressors import at_step_ends, friction_over_steps
from state_estimation.motors import motors_of
from synchronisation.encoder_log import uniformly_sampled
from tests.state_estimation.test_state import COUNTS, NECK
from xneck_foundation.strict_yaml import parse_yaml

ARM = arm_of(read_neck(NECK))
RATE = 500.0


def test_friction_over_a_step_is_its_integral() -> None:
    """Reversals within a step, slow ones, rest and a speed that stays, against 10 000 points a step."""
    speed = np.array([-3.0, 5.0, 5.0, 0.1, -0.1, 0.0, 0.0, -40.0])[:, None]
    dried, transition, viscous = friction_over_steps(speed)
    fine = np.linspace(speed[:-1, 0], speed[1:, 0], 10_001)
    for mean, exact in ((dried, dry(fine)), (transition, CM * fine / (1 + (CM * fine) ** 2)), (viscous, fine)):
        np.testing.assert_allclose(mean[:, 0], np.trapezoid(exact, dx=1e-4, axis=0), atol=1e-6)


def test_means_over_steps_tell_a_cubic_at_their_ends() -> None:
    t = np.arange(12.0)[:, None]
    means = np.diff(t**4 / 4 - t**2, axis=0)
    np.testing.assert_allclose(at_step_ends(means)[2:-2], (t**3 - 2 * t)[2:-2], atol=1e-9)


@pytest.mark.parametrize(("damping", "late_s"), [(0.0, 0.0), (60.0, 0.0), (0.0, 1e-3)])
def test_damped_cables_and_dry_friction_are_explained_to_the_encoders_noise(damping: float, late_s: float) -> None:
    """Elongations of a millimetre, motion to 5 Hz: what no beta explains is 2 um (encoders' noise in theta'', times Ia R/rd / k).

    Of damped cables a rate in place of the lag leaves 8 to 32 um. Of commands that are late by half a step the rate of n in
    place of that of f leaves 9 to 22 um.
    """
    k = np.array([10e3, 9e3, 8e3, 5.5e3])
    world = World(parse_yaml(NECK.read_text(), str(NECK)), stretch=linear(k, np.full(4, damping)))
    made = prescribe(world, 20.0, 0, (0.1, 5.0), (8.0, 9.6))
    log = uniformly_sampled(
        Series(made.log_time, numbered_columns("theta", made.counted) | numbered_columns("f", made.f))
    )
    motors = motors_of(log, COUNTS)
    f = np.stack([np.interp(motors.time + late_s, motors.time, column) for column in motors.f.T], axis=-1)
    frames = made.clocks.log_time(made.frame_times)
    rows = np.flatnonzero((motors.time > frames[0]) & (motors.time < frames[-1]))
    x = elongation(ARM, made.alpha[np.searchsorted(made.log_time, motors.time - 1e-6)], motors.theta)
    seen = np.stack([np.interp(frames, motors.time, column) for column in x.T], axis=-1)
    seen += np.random.default_rng(1).normal(0, 5e-5, seen.shape)
    X = law_of(ARM, replace(motors, f=f), frames, seen).at(motors.time[rows])
    for j in range(4):
        residuals = x[rows, j] - X[:, j] @ np.linalg.lstsq(X[:, j], x[rows, j], rcond=None)[0]
        assert np.std(residuals) < 4e-6, np.std(residuals)
        assert np.std(x[rows, j]) > 5e-4
