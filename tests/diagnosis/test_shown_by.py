"""What pictures have along their axes, of a recording whose signals rise evenly: filtered they are what they were."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis import shown_by
from diagnosis.shown_by import ShownBy
from mechanism.cable_lengths import lengths
from mechanism.description import read_neck
from tests.identification.test_rows import signals
from tests.paths import NECK_FILE

ROWS = 1500
GEARS = np.array([25.0, 10.0, 40.0, 25.0])
TURNS_A_SECOND = np.array([0.1, 0.2, -0.3, 0.4])
"""of the drums"""
PRE_ELONGATION = np.array([1e-3, 2e-3, 3e-3, 4e-3])
TENSION_RATE = np.array([5.0, -2.0, 1.0, 0.5])
"""N/s"""


def recording() -> Any:
    neck = read_neck(NECK_FILE)
    motors = tuple(m.model_copy(update={"R": gear}) for m, gear in zip(neck.motors, GEARS, strict=True))
    s = signals(np.random.default_rng(0), ROWS)
    t, one = s.time[:, None], np.ones((ROWS, 4))
    tension = 50 + TENSION_RATE * t
    return SimpleNamespace(
        hypothesis=SimpleNamespace(neck=neck.model_copy(update={"motors": motors})),
        signals=replace(
            s,
            theta=2 * np.pi * GEARS * TURNS_A_SECOND * t,
            theta_d=one * [1.0, 2.0, 3.0, 4.0] + t,
            theta_dd=one * [5.0, 6.0, 7.0, 8.0],
            f=40 + t * [1.0, 2.0, 3.0, 4.0],
            alpha=0.05 * t * [1.0, 2.0, -4.0],
            alpha_d=np.tile(0.05 * np.array([1.0, 2.0, -4.0]), (ROWS, 1)),
            x=1e-3 * t * [1.0, 2.0, 3.0, 4.0],
        ),
        tension=tension,
        motor_forces=SimpleNamespace(pull=tension),
        x0=PRE_ELONGATION,
    )


@pytest.mark.parametrize(
    ("shown", "place", "begin", "rate", "unit"),
    [
        (shown_by.DRUM_TURNS, 0, 0.0, 0.1, "turns"),
        (shown_by.DRUM_TURNS, 2, 0.0, -0.3, "turns"),
        (shown_by.MOTOR_SPEED, 1, 2.0, 1.0, "rad/s"),
        (shown_by.MOTOR_ACCELERATION, 3, 8.0, 0.0, "rad/s^2"),
        (shown_by.FORCE, 2, 40.0, 3.0, "N"),
        (shown_by.FORCE_RATE, 2, 3.0, 0.0, "N/s"),
        (shown_by.TENSION, 1, 50.0, -2.0, "N"),
        (shown_by.TENSION_ALONG_MOTION, 0, 50.0, 5.0, "N"),
        (shown_by.TENSION_RATE, 1, -2.0, 0.0, "N/s"),
        (shown_by.ELONGATION, 3, 4e-3, 4e-3, "m"),
        (shown_by.JOINT_ANGLE, 1, 0.0, 0.1, "rad"),
        (shown_by.JOINT_SPEED, 2, -0.2, 0.0, "rad/s"),
        (shown_by.LEAN, 0, 0.0, -0.05, "rad"),
    ],
)
def test_an_axis_has_what_its_name_and_unit_say(
    shown: ShownBy, place: int, begin: float, rate: float, unit: str
) -> None:
    """begin, rate: in that unit, and in it a second."""
    of = recording()
    assert shown.unit == unit
    np.testing.assert_allclose(shown.values(of, place), begin + rate * of.signals.kept_time, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("cable", range(4))
def test_joints_lengthen_a_cables_way_as_its_length_says(cable: int) -> None:
    of = recording()
    s = of.signals
    along = np.gradient(lengths(s.arm, s.alpha)[:, cable], s.step)
    np.testing.assert_allclose(shown_by.CABLE_RATE.values(of, cable), s.low_pass(along), rtol=1e-3)


def test_a_motor_that_turned_round_has_come_as_far_since() -> None:
    """It turns on by 4 rad/s, and back by 3 rad/s from one second on; its drum winds 0.4 mm a radian.

    A bend is seen up to six times the bristles' 0.1 rad, a travel up to four times the 0.2 mm in which play is crossed."""
    of = recording()
    s = of.signals
    forward = s.time < 1.0
    theta = np.where(forward, 4 * s.time, 4 - 3 * (s.time - 1))[:, None] * np.ones(4)
    of.signals = replace(s, theta=theta, theta_d=np.where(forward, 4.0, -3.0)[:, None] * np.ones(4))
    of.values = {"wp": np.array([0.1]), "play": np.full(4, 2e-4), "pb": np.array([0.5])}
    kept = s.kept_time
    back = 3 * (kept - kept[kept >= 1.0][0])[kept >= 1.0]
    bend, travel = (shown.values(of, 0)[kept >= 1.0] for shown in (shown_by.BENDING, shown_by.REVERSALS))
    np.testing.assert_allclose(bend, np.where(back <= 0.6, back, np.nan), atol=1e-12)
    np.testing.assert_allclose(travel, np.where(back <= 2.0, 4e-4 * back, np.nan), atol=1e-15)
