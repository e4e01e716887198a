"""Clocks of motors that stick: at rest friction holds them at any force up to its greatest, which no law of their speed tells."""

import numpy as np
import pytest

from identification import motor_rest
from identification.dataset.series import Series, numbered_columns
from identification.motor_rest import error_at_rest, rests_near
from mechanism.arm import arm_of
from mechanism.description import Neck
from samples.forward_arms import Settings, make_arms
from samples.forward_arms.drawing import neck as neck_of
from samples.forward_arms.laws import Presliding
from synchronisation.angles import Angles
from synchronisation.clocks.clock import fit_clock
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.strict_yaml import validate_document

SEED = 5031
WITHIN_A_COUNT_RAD = 1e-3
"""over which bristles bend: less than an encoder of 2048 counts sees, so that a motor stands where it stands"""


def test_the_clock_stands_where_motors_stick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Within 3.3 sigma, a chance of one in a thousand; the law alone would leave it three times as uncertain."""
    settings = Settings(seconds=20.0, noise_deg=0.03, step=2e-3)
    one = next(iter(make_arms([SEED], settings, hidden=[(Presliding(np.full(4, WITHIN_A_COUNT_RAD)),)])))
    recording, film = one.recordings[0], one.recordings[0].film
    angles = Angles(film.stamp, film.seen, np.full_like(film.seen, film.noise))
    log = Series(recording.time, numbered_columns("theta", recording.theta) | numbered_columns("f", recording.f))
    assert rests_near(recording.theta, 500.0).mean() > 0.1
    arm = arm_of(validate_document(neck_of(one.drawing), Neck, "neck.yaml"))
    fitted = one_blas_thread(fit_clock)
    found = fitted(arm, angles, log)
    monkeypatch.setattr(motor_rest, "MIN_REST_RATIO", np.inf)
    by_law = fitted(arm, angles, log)
    assert abs(found.offset - (film.offset + film.skew * found.middle)) < 3.3 * found.offset_sigma
    assert found.offset_sigma < 1e-3
    assert by_law.offset_sigma > 2 * found.offset_sigma


def test_a_motor_rests_about_where_it_does_not_turn() -> None:
    rate, still = 500.0, np.zeros(200)
    theta = np.concatenate([np.linspace(-8, 0, 500), still, np.linspace(0, 8, 500)])[:, None]
    rests = rests_near(np.hstack([theta, theta + np.linspace(0, 3, len(theta))[:, None]]), rate)
    assert rests[500:700, 0].all()
    assert not rests[:460, 0].any()
    assert not rests[740:, 0].any()
    assert not rests[:, 1].any()


def test_an_error_at_rest_is_what_is_more_there() -> None:
    rng, at_rest = np.random.default_rng(3), np.zeros((4000, 3), dtype=bool)
    at_rest[1000:2000] = True
    at_rest[:, 2] = False
    at_rest[:30, 2] = True
    residual = rng.normal(0, 1.0, at_rest.shape)
    residual[at_rest] *= 3.0
    residual[:, 1] = rng.normal(0, 1.0, 4000)
    found = error_at_rest(residual, at_rest)
    assert found[0] == pytest.approx(np.sqrt(8), rel=0.1)
    assert list(found[1:]) == [0.0, 0.0]
    # of micrometres: counts of the encoder, and no friction that holds
    assert not error_at_rest(3e-6 * residual, at_rest).any()
    assert error_at_rest(3e-5 * residual, at_rest)[0] > 0
