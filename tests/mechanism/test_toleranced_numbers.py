"""Every number with a tolerance, moved, changes itself in the arm and nothing else."""

from dataclasses import fields

import numpy as np
import pytest

from mechanism.arm import Arm, arm_of
from mechanism.description import Spring, read_neck
from mechanism.tolerance import Tolerance
from mechanism.toleranced_numbers import moved, tilted, toleranced_numbers, with_springs_apart
from tests.paths import NECK_FILE

NECK = read_neck(NECK_FILE)
ARM = arm_of(NECK)
NUMBERS = {number.name: number for number in toleranced_numbers(NECK)}
SHARE = 0.01
PLACES: dict[str, tuple[str, tuple[int, ...]]] = {
    "L of mechanism 2": ("L", (1,)),
    "b of mechanism 3": ("b", (2,)),
    "pulleys of mechanism 1": ("r", (0,)),
    "mass of top bar 2": ("top_mass", (1,)),
    "mass of diagonals 3": ("diagonal_mass", (2,)),
    "inertia of top bar 1": ("top_inertia", (0,)),
    "inertia of diagonals 2": ("diagonal_inertia", (1,)),
    "spring 2 left": ("spring_stiffness", (0, 1)),
    "spring 2 right": ("spring_stiffness", (1, 1)),
    "free length of spring 3 left": ("spring_free_length", (0, 2)),
    "free length of spring 3 right": ("spring_free_length", (1, 2)),
    "inertia of motor 4": ("motor_inertia", (3,)),
    "drum 1": ("drum", (0,)),
}
"""by name: the arm's array, and where in it"""


def changed(arm: Arm) -> dict[str, np.ndarray]:
    """Ratio to the sample's of the arrays that differ from it."""
    assert (arm.routes, arm.spring_slack) == (ARM.routes, ARM.spring_slack)
    names = [f.name for f in fields(Arm) if f.name not in ("routes", "spring_slack")]
    return {
        name: getattr(arm, name) / getattr(ARM, name)
        for name in names
        if not np.array_equal(getattr(arm, name), getattr(ARM, name))
    }


@pytest.mark.parametrize("name", PLACES)
def test_a_number_that_is_moved_changes_itself_alone(name: str) -> None:
    key, place = PLACES[name]
    ((found, ratio),) = changed(arm_of(NUMBERS[name].moved(NECK, SHARE))).items()
    assert found == key
    expected = np.ones(ratio.shape)
    expected[place] += SHARE
    np.testing.assert_allclose(ratio, expected, rtol=1e-12)


def test_no_two_numbers_are_the_same() -> None:
    assert len(NUMBERS) == len(toleranced_numbers(NECK)) == 11 * NECK.N + 2 * NECK.M + 1
    after = {repr(number.moved(NECK, SHARE)) for number in NUMBERS.values()}
    assert len(after) == len(NUMBERS)


def test_every_kind_is_a_key_of_the_tolerance_and_has_its_sigma() -> None:
    kinds = {number.kind for number in NUMBERS.values()}
    # markers are what angles are read with, and forms of laws are no lengths or masses: neither is a number of the arm
    assert kinds == set(Tolerance.model_fields) - {"marker_angle", "friction_curve"}
    well_known = NECK.model_copy(update={"tolerance": Tolerance(mass=0.5, tilt=0.05)})
    sigma = {number.name: number.sigma for number in toleranced_numbers(well_known)}
    assert sigma["mass of top bar 1"] == sigma["mass of diagonals 3"] == 0.5
    assert sigma["tilt of the base"] == 0.05
    assert sigma["L of mechanism 1"] == Tolerance().length


def test_numbers_are_moved_one_after_the_other() -> None:
    names = ["spring 1 right", "spring 1 left", "drum 2"]
    arm = arm_of(moved(NECK, [NUMBERS[name] for name in names], [0.1, -0.2, 0.3]))
    np.testing.assert_allclose(arm.spring_stiffness[:, 0] / ARM.spring_stiffness[:, 0], [0.8, 1.1])
    np.testing.assert_allclose(arm.drum / ARM.drum, [1, 1.3, 1, 1])


def test_springs_apart_are_the_same_arm() -> None:
    apart = NECK.model_copy(update={"mechanisms": tuple(with_springs_apart(m) for m in NECK.mechanisms)})
    assert all(m.springs.right is not None for m in apart.mechanisms)
    assert changed(arm_of(apart)) == {}


def test_a_right_spring_of_its_own_stays_as_it_is() -> None:
    own = Spring(stiffness=123.0, free_length=0.03)
    first, *rest = NECK.mechanisms
    first = first.model_copy(update={"springs": first.springs.model_copy(update={"right": own})})
    neck = NECK.model_copy(update={"mechanisms": (first, *rest)})
    assert with_springs_apart(first) == first
    arm = arm_of(NUMBERS["spring 1 left"].moved(neck, SHARE))
    assert (arm.spring_stiffness[1, 0], arm.spring_free_length[1, 0]) == (123.0, 0.03)


def test_a_base_that_leans_counter_clockwise_sees_gravity_lean_clockwise() -> None:
    arm = arm_of(NUMBERS["tilt of the base"].moved(NECK, 0.1))
    g = np.hypot(*NECK.gravity)
    np.testing.assert_allclose(arm.gravity, [-g * np.sin(0.1), -g * np.cos(0.1)], rtol=1e-12)
    unmoved = NECK.model_copy(update={"gravity": NUMBERS["tilt of the base"].moved(NECK, 0.1).gravity})
    assert NUMBERS["tilt of the base"].moved(NECK, 0.1) == unmoved
    np.testing.assert_allclose(tilted(tilted(NECK, 0.1), -0.1).gravity, NECK.gravity, atol=1e-12)
