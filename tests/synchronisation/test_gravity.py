"""Gravity that is described otherwise than it pulls is named; loads, masses and a base that leans are not taken for it."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from identification.dataset.series import Series, numbered_columns
from mechanism.arm import arm_of
from mechanism.description import Neck
from samples.generator.prescribed import Prescribed, World, prescribe
from samples.worlds.changed_recordings import faultless
from samples.worlds.clock_worlds import NOISE_RAD
from synchronisation.angles import Angles
from synchronisation.gravity_plausibility import other_gravity
from synchronisation.log_plausibility import check_log_meaning
from synchronisation.log_regression import fitted_gravity, logged_motion
from xneck_foundation.strict_yaml import validate_document

HANGING = (0.0, -9.81)


@cache
def recorded(gravity: tuple[float, float], seed: int = 3) -> tuple[Neck, Prescribed]:
    """An arm under this gravity, and its description as it is."""
    neck = {**faultless().neck, "gravity": list(gravity)}
    described = validate_document(neck, Neck, "neck.yaml")
    return described, prescribe(World(neck), 20.0, seed)


def log_of(p: Prescribed) -> Series:
    return Series(p.log_time, numbered_columns("theta", p.counted) | numbered_columns("f", p.f))


def warnings_of(described: Neck, p: Prescribed) -> tuple[str, ...]:
    angles = Angles(p.frame_times, p.frame_alpha, np.full_like(p.frame_alpha, NOISE_RAD))
    return check_log_meaning(described, arm_of(described), angles, log_of(p))


@pytest.mark.parametrize("gravity", [HANGING, (0.0, 0.0), (9.81, 0.0), (6.9, -6.9)])
def test_gravity_as_described_is_not_doubted(gravity: tuple[float, float]) -> None:
    described, p = recorded(gravity)
    assert warnings_of(described, p) == ()
    arm = arm_of(described)
    motion = logged_motion(arm, p.frame_times, p.frame_alpha, log_of(p))
    assert motion is not None
    fit = fitted_gravity(arm, motion)
    assert np.all(np.abs(fit.gravity - gravity) < 4 * fit.sigma + 0.3)  # a rough filter's own error besides


@pytest.mark.parametrize(
    ("true", "said", "words"),
    [
        (HANGING, (0.0, 9.81), r"gravity of -(9|10)\.\d \+- 0\.\d m/s\^2 along the straight arm, .*write gravity: \[0, -9\.81\]"),
        (HANGING, (0.0, 0.0), r"neck.yaml has gravity: \[0, 0\], .*write gravity: \[0, -9\.81\]"),
        ((0.0, 0.0), HANGING, r"gravity of -?0\.\d .* in a level plane has gravity: \[0, 0\]"),
    ],
)  # fmt: skip
def test_another_gravity_is_named_and_nothing_else_is_doubted(
    true: tuple[float, float], said: tuple[float, float], words: str
) -> None:
    """Forces are held against the arm as it moves, so that nobody is told to change their unit."""
    _, p = recorded(true)
    described = recorded(said)[0]
    (warning,) = warnings_of(described, p)
    assert re.search(words, warning), warning


def test_loads_masses_and_a_base_that_leans_are_no_other_gravity() -> None:
    """Nor is what they are described as, where it is more than there is."""
    described, p = recorded(HANGING)
    arm = arm_of(described)
    motion = logged_motion(arm, p.frame_times, p.frame_alpha, log_of(p))
    assert motion is not None
    leaning = 9.81 * np.array([np.sin(0.2), -np.cos(0.2)])
    for other in (
        replace(arm, top_mass=arm.top_mass * [1.0, 1.0, 4.0]),
        replace(arm, top_mass=arm.top_mass / 2, diagonal_mass=arm.diagonal_mass / 2),
        replace(arm, top_mass=arm.top_mass * 2, diagonal_mass=arm.diagonal_mass * 2),
        replace(arm, gravity=leaning),
    ):
        same, words = other_gravity(described, other, motion)
        assert same is other
        assert words == ()
