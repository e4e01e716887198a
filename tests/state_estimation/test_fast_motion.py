"""What motors shake the arm by between the knots, against arms integrated forward: nothing here knows how they were made.

The arms' own commands go from row to row in steps, their encoders count, and their cables are damped as they may be.
"""

import json
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, numbered_columns
from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from samples.forward_arms import Settings, make_arms
from samples.forward_arms.arms import Arm as ForwardArm
from samples.forward_arms.drawing import neck
from state_estimation.elongation_law import ElongationLaw
from state_estimation.elongation_regressors import force_signals
from state_estimation.fast_motion import fast_motion_variance
from state_estimation.motors import Motors, motors_of
from state_estimation.spline import CARRIED
from state_estimation.state import KNOT_S, StateEstimate, estimate_state
from synchronisation.encoder_log import uniformly_sampled

Array = NDArray[np.float64]

SEEDS = (40, 41)
SECONDS = 20.0


@dataclass(frozen=True)
class Seen:
    """An arm with its first recording as the state's estimate has it, and what it did at the log's rows."""

    arm: Arm
    made: ForwardArm
    motors: Motors
    frames: FrameAngles
    inside: slice
    truth: tuple[Array, Array, Array]

    @property
    def estimate(self) -> StateEstimate:
        """By vision and cables, with the true clock."""
        return estimate_state(self.arm, self.frames, self.motors, self.motors.time[self.inside])


@cache
def seen() -> tuple[Seen, ...]:
    settings = Settings(base="exact", seconds=SECONDS, recordings=1, noise_deg=0.02, step=1e-3)
    out = []
    for made in make_arms(SEEDS, settings):
        described = Neck.model_validate_json(json.dumps(neck(made.drawing)))
        recording = made.recordings[0]
        film, true = recording.film, recording.truth.within_log()
        columns = numbered_columns("theta", recording.theta) | numbered_columns("f", recording.f)
        motors = motors_of(uniformly_sampled(Series(recording.time, columns)), described.count_angles)
        sigma = np.full(film.seen.shape, film.noise)
        inside = slice(*np.searchsorted(motors.time, (film.log_time[0] + 1, film.log_time[-1] - 1)))
        alpha, alpha_d, alpha_dd = (v[:: true.per_row][inside] for v in (true.alpha, true.alpha_d, true.alpha_dd))
        frames = FrameAngles(film.log_time, film.seen, sigma, np.zeros_like(sigma))
        out.append(
            Seen(
                arm=arm_of(described),
                made=made,
                motors=motors,
                frames=frames,
                inside=inside,
                truth=(alpha, alpha_d, alpha_dd),
            )
        )
    return tuple(out)


@pytest.mark.parametrize("which", range(len(SEEDS)))
def test_accelerations_beyond_the_knots_are_as_large_as_the_motors_make_them(which: int) -> None:
    """By true friction and elasticity, linear about four poses: within a third of each joint's true power."""
    case = seen()[which]
    plant = case.made.plant
    motors = case.motors.with_friction(case.arm, plant.dry, np.zeros(case.arm.M))
    law = ElongationLaw(
        arm=case.arm,
        motors=motors,
        signals=force_signals(case.arm, motors),
        lag=plant.damping / plant.stiffness,
        friction=np.zeros((case.arm.M, 3)),
    )
    variance = fast_motion_variance(law, 1 / plant.stiffness, case.truth[0], KNOT_S)
    assert variance is not None
    rate = 1 / float(np.mean(np.diff(motors.time)))
    beyond = butter(8, CARRIED / KNOT_S, "high", fs=rate, output="sos")
    true = np.var(sosfiltfilt(beyond, case.truth[2], axis=0), axis=0)
    np.testing.assert_allclose(variance[2] / true, 1.0, atol=1 / 3)


@pytest.mark.parametrize("which", range(len(SEEDS)))
def test_sigma_of_a_shaken_arm_is_what_its_state_errs_by(which: int) -> None:
    """Of angles, rates and accelerations alike, by vision and cables; without what knots cannot carry, accelerations err by 3."""
    case = seen()[which]
    state = case.estimate
    rows = np.searchsorted(state.time, state.covariance_time - 1e-9)
    variance = np.diagonal(state.covariance, axis1=1, axis2=2)
    n = case.arm.N
    for derivative, (estimate, true) in enumerate(
        zip((state.alpha, state.alpha_d, state.alpha_dd), case.truth, strict=True)
    ):
        e = (estimate - true)[rows]
        z = float(np.sqrt(np.mean(e**2 / variance[:, derivative * n : (derivative + 1) * n])))
        assert 0.6 < z < 1.4


def test_friction_is_told_where_the_motors_turn_round() -> None:
    """Speeds by the motors' equations halve what the state errs by: the rows alone give an error that cables then believe."""
    case = seen()[0]
    at_rows = replace(case.motors, counted=None)
    without = estimate_state(case.arm, case.frames, at_rows, case.motors.time[case.inside])
    errors = [float(np.sqrt(np.mean((s.alpha - case.truth[0]) ** 2))) for s in (case.estimate, without)]
    assert errors[0] < 0.7 * errors[1]
