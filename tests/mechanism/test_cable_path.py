"""A cable's way, put together from tangents and arcs, is as long as the closed forms say, and on the right side of its pulleys."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mechanism.arm import Arm
from mechanism.cable_lengths import lengths, wrap_angles
from mechanism.cable_path import Contact, bar_ends, cable_contacts, path_length, path_points
from mechanism.geometry import poses

WORDS = {"right": ("strut", "right_through"), "left": ("strut_mirrored", "left_through")}


def arm_with(routes: tuple[tuple[str, ...], ...], seed: int) -> Arm:
    rng = np.random.default_rng(seed)
    n, m = max(map(len, routes)), len(routes)
    L = rng.uniform(0.08, 0.12, n)
    b = np.full(n, 0.5 * L.min())
    one, two = np.ones(n), np.ones((2, n))
    return Arm(
        L=L,
        b=b,
        r=np.full(n, 0.1 * b[0]),
        diagonal_mass=one,
        diagonal_inertia=one,
        top_mass=one,
        top_inertia=one,
        top_com=np.zeros((n, 2)),
        spring_stiffness=two,
        spring_free_length=two,
        gravity=np.array([0.0, -9.81]),
        x0=np.zeros(m),
        cable_length=np.ones(m),
        section=np.ones(m),
        drum=np.ones(m),
        gear=np.ones(m),
        motor_inertia=np.ones(m),
        spring_slack=(False,) * n,
        routes=routes,
    )


def any_routes(seed: int) -> tuple[tuple[str, ...], ...]:
    rng = np.random.default_rng([seed, 1])
    found: list[tuple[str, ...]] = [("right",), ("left",)]
    for _ in range(6):
        side = str(rng.choice(["right", "left"]))
        words = [str(rng.choice(WORDS[side])) for _ in range(rng.integers(0, 5))]
        found.append((*words, str(rng.choice([side, *WORDS[side]]))))
    return tuple(found)


@pytest.mark.parametrize("seed", range(12))
def test_it_is_as_long_as_the_closed_forms_say(seed: int) -> None:
    """Equations (19), (20), (25), (30) against tangents of circles: two derivations that share nothing but the convention."""
    arm = arm_with(any_routes(seed), seed)
    alpha = np.random.default_rng(seed).uniform(-0.9, 0.9, arm.N)
    ways = [cable_contacts(arm, alpha, j) for j in range(arm.M)]
    np.testing.assert_allclose([path_length(way) for way in ways], lengths(arm, alpha), rtol=1e-12)
    wound = [sum(abs(c.end - c.begin) for c in way) for way in ways]
    np.testing.assert_allclose(wound, wrap_angles(arm, alpha), rtol=1e-12)


def test_a_cable_on_the_other_side_of_its_pulley_is_not() -> None:
    """Within the arm instead of outside: the arc is longer or shorter by the angle of the joint."""
    arm, alpha = arm_with((("right",),), 0), np.array([0.4])
    (pulley, end) = cable_contacts(arm, alpha, 0)
    towards = float(np.angle(end.centre - pulley.centre))
    inside = Contact(pulley.centre, pulley.radius, pulley.begin + 2 * np.pi, 2 * towards - pulley.end)
    difference = path_length([inside, end]) - lengths(arm, alpha)[0]
    assert difference == pytest.approx(-arm.r[0] * alpha[0], rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_straight_pieces_touch_their_pulleys_and_arcs_are_on_them(seed: int) -> None:
    arm = arm_with(any_routes(seed), seed)
    alpha = np.random.default_rng(seed).uniform(-0.6, 0.6, arm.N)
    for j in range(arm.M):
        way = cable_contacts(arm, alpha, j)
        for here, there in pairwise(way):
            piece = there.points[0] - here.points[-1]
            if abs(piece) < 1e-9:
                continue  # the lowest point, where one portion hands the cable to the next
            for contact, point in ((here, here.points[-1]), (there, there.points[0])):
                assert abs(abs(point - contact.centre) - contact.radius) < 1e-12
                across = (point - contact.centre) * np.conj(piece)
                assert abs(across.real) <= 1e-9 * abs(piece)


def test_it_runs_on_the_outer_side() -> None:
    """Of the pulleys of the base: to the right of the right one, to the left of the left one."""
    arm = arm_with((("right_through", "right"), ("left_through", "left")), 3)
    ends = bar_ends(arm, poses(arm, np.zeros(2)))
    right, left = (path_points(cable_contacts(arm, np.zeros(2), j)) for j in (0, 1))
    assert right.real.max() == pytest.approx(ends[0, 1].real + arm.r[0], rel=1e-3)
    assert left.real.min() == pytest.approx(ends[0, 0].real - arm.r[0], rel=1e-3)


def test_cables_drawn_apart_stay_outside_of_each_other() -> None:
    arm = arm_with((("strut", "right"),), 5)
    bare, wide = (cable_contacts(arm, np.array([0.2, -0.3]), 0, wider) for wider in (0.0, 1e-3))
    assert path_length(wide) > path_length(bare)
    assert [c.radius for c in wide[:-1]] == pytest.approx([c.radius + 1e-3 for c in bare[:-1]])


def test_without_pulleys_it_goes_from_axle_to_axle() -> None:
    arm = replace(arm_with((("strut", "right"), ("left_through", "left")), 2), r=np.zeros(2))
    alpha = np.array([0.3, -0.2])
    np.testing.assert_allclose(
        [path_length(cable_contacts(arm, alpha, j)) for j in range(2)], lengths(arm, alpha), rtol=1e-12
    )
