"""Recordings whose motion is given: the arm's equation, the cables' law and the motors' equation hold in what they write."""

import numpy as np
import pytest
import yaml

from mechanism.arm import arm_of
from mechanism.cable_lengths import Z
from mechanism.description import read_neck
from mechanism.dynamics import terms
from mechanism.elasticity import elongation
from mechanism.friction import dry
from samples.generator.laws import cubic, damped, linear, maxwell_slip, play, toe, with_creep
from samples.generator.mujoco_arm import Load
from samples.generator.prescribed import World, prescribe
from tests.paths import NECK_FILE

FILE = NECK_FILE
NECK = yaml.safe_load(FILE.read_text(encoding="utf-8"))
ARM = arm_of(read_neck(FILE))
K, CA = np.array([10e3, 9e3, 8e3, 5.5e3]), np.full(4, 60.0)
TIME = np.arange(0, 5, 2e-4)
PULL = 60 + 30 * np.sin(2 * np.pi * 0.7 * TIME[:, None] + np.arange(4))


@pytest.fixture(scope="module")
def made():  # type: ignore[no-untyped-def]
    return prescribe(World(NECK), 20.0, 1)


def test_the_arm_equation_holds(made) -> None:  # type: ignore[no-untyped-def]
    """M alpha'' + c + g = Z t by the closed forms, for torques that were got from places in time: two formulations."""
    at = terms(ARM, made.alpha, made.alpha_d)
    left = np.einsum("tij,tj->ti", at.M, made.alpha_dd) + at.c + at.g
    right = np.einsum("tij,tj->ti", Z(ARM, made.alpha), made.tension)
    assert np.abs(left - right).max() < 2e-6 < 0.1 < np.abs(right).max()


def test_a_payload_shows_in_the_arm_equation() -> None:
    made = prescribe(World(NECK, load=Load(payload_kg=0.1)), 10.0, 1)
    at = terms(ARM, made.alpha, made.alpha_d)
    left = np.einsum("tij,tj->ti", at.M, made.alpha_dd) + at.c + at.g
    assert np.abs(left - np.einsum("tij,tj->ti", Z(ARM, made.alpha), made.tension)).max() > 0.05


def test_elongations_follow_from_exact_lengths(made) -> None:  # type: ignore[no-untyped-def]
    np.testing.assert_allclose(elongation(ARM, made.alpha, made.theta), made.x, atol=1e-12)


def test_the_motor_equation_holds_between_two_rows(made) -> None:  # type: ignore[no-untyped-def]
    """Over one period the held force does what tension, friction and the rotor take; at the row itself it does not."""
    theta_d = np.gradient(made.theta, made.log_time, axis=0)
    theta_dd = np.gradient(theta_d, made.log_time, axis=0)
    needs = made.tension + dry(theta_d) * [14, 17, 18, 16] + ARM.motor_inertia / ARM.drum * theta_dd
    over, at = (made.f[1:-1] - wanted for wanted in ((needs[1:-1] + needs[2:]) / 2, needs[1:-1]))
    assert np.std(over) < 0.05 < 0.1 < np.std(at), "N; straight lines between rows miss friction's bends"


@pytest.mark.parametrize("spring", [cubic(np.full(4, 4e3), np.full(4, 1e8)), toe(np.full(4, 3e3), np.full(4, 200.0))])
def test_a_hard_spring_with_a_damper_obeys_its_law(spring) -> None:  # type: ignore[no-untyped-def]
    x = damped(spring, np.full(4, 3e4), CA)(PULL, 2e-4)
    pull = spring(x) + CA * np.gradient(x, 2e-4, axis=0)
    assert np.abs(pull - PULL)[5:-5].max() < 1e-3


def test_creep_ends_at_its_compliance() -> None:
    step = np.where(TIME[:, None] < 0.01, 40.0, 80.0) * np.ones(4)
    rigid, slow = (law(step, 2e-4) for law in (linear(K, CA), with_creep(linear(K, CA), np.full(4, 1e-5), 0.5)))
    np.testing.assert_allclose((slow - rigid)[-1], 80e-5 - 40e-5 * np.exp(-(TIME[-1] - 0.01) / 0.5), rtol=1e-3)


def test_a_play_is_followed_step_by_step() -> None:
    """With turns in between, and values that stay for a while."""
    values, half, y = np.rint(PULL), np.array([0.0, 0.5, 5.0, 50.0]), np.rint(PULL[0])
    expected = []
    for row in values:
        y = np.clip(y, row - half, row + half)
        expected.append(y)
    np.testing.assert_array_equal(play(values, half), expected)


def test_elements_that_slip_make_a_loop() -> None:
    """Between going and coming lies twice the force of all elements, once all of them slip; going slowly, at one elongation."""
    k, force, travel = np.full(4, 8e3), 3.0, np.array([0.2e-3, 0.4e-3, 0.8e-3])[:, None] * np.ones(4)
    slow = 60 + 40 * np.sin(2 * np.pi * 0.2 * TIME[:, None]) * np.ones(4)
    x = maxwell_slip(k, np.zeros(4), force / 3 / travel, travel)(slow, 2e-4)
    back, forth = (np.interp(55 / 8e3, side[:, 0], pull[:, 0]) for side, pull in _ways(x, slow))
    assert forth - back == pytest.approx(2 * force, abs=1e-3)


def _ways(x: np.ndarray, pull: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """Coming back between 1.25 and 3.75 s, in rising order, and going on after that."""
    back, forth = (TIME > 1.25) & (TIME < 3.75), TIME > 3.75
    return (x[back][::-1], pull[back][::-1]), (x[forth], pull[forth])
