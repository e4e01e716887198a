"""Joints that stick: what friction holds at rest is part of sigma there, and of no joint that moves."""

from dataclasses import replace

import numpy as np

from mechanism.cable_lengths import geometry_of_poses
from mechanism.friction import HELD_VARIANCE
from mechanism.laws import JointMotion
from observation.observer import Observer
from observation.resting_arm import compliance
from tests.observation.arms import SEEDS, case, with_laws

NUMBERS = {"cj": 0.08, "dj": 0.0, "vj": 0.01, "nj": 3.0, "mu": 0.0, "ma": 0.01, "vp": 1e-3, "wm": -0.2}
ROWS = 3000
"""of an arm at rest: after so many what is not known of speeds where it begins has faded"""


def observer(*laws: str) -> Observer:
    """Of an arm, with more laws."""
    of = with_laws(case(SEEDS[0]), laws, NUMBERS)
    return Observer(of.neck, of.model)


def test_what_is_held_is_that_of_the_machine() -> None:
    """In joints and on pulleys, at rest and in motion, by the equations written as code."""
    of = observer("joint_friction", "pulley_friction")
    layout, machine = of.numbers.layout, of.numbers.machine
    state = of.state.copy()
    state[layout.alpha], state[layout.theta] = (0.2, -0.1, 0.15), 3.0
    state[layout.x0] = 3e-3
    for speed in (np.zeros(3), np.array([0.004, -0.02, 0.3])):
        state[layout.alpha_d] = speed
        e = of.prediction.equations.at(state, np.zeros(4), 0.0)
        alpha = state[layout.alpha][None]
        g = geometry_of_poses(machine.arm, alpha)
        held = machine.held_torque(JointMotion(alpha, speed[None]), g.Z, g.wraps, e.tension[None])[0]
        np.testing.assert_allclose(e.held, held**2, rtol=1e-9)


def test_sigma_at_rest_is_what_friction_holds_times_compliance() -> None:
    of = case(SEEDS[0])
    theta, f = of.log.matrix("theta"), of.log.matrix("f")
    sticking, free = observer("joint_friction"), observer()
    variance = []
    for each in (sticking, free):
        for _ in range(ROWS):
            each.step(theta[0], f[0])
        variance.append(np.diag(each.observed.covariance)[:3])
    layout = free.numbers.layout
    machine = free.numbers.machine
    machine = replace(machine, arm=replace(machine.arm, x0=free.state[layout.x0]))
    C = compliance(machine, free.state[layout.alpha][None], free.state[layout.theta][None])[0]

    expected = HELD_VARIANCE * NUMBERS["cj"] ** 2 * np.sum(C**2, axis=1)
    np.testing.assert_allclose(variance[0] - variance[1], expected, rtol=0.15)


def test_a_joint_that_moves_is_held_by_nothing() -> None:
    """Ten times as fast as its friction turns over."""
    of = observer("joint_friction")
    state = of.state.copy()
    state[of.numbers.layout.alpha_d] = 10 * NUMBERS["vj"]
    held = of.prediction.equations.at(state, np.zeros(4), 0.0).held
    assert np.sqrt(held).max() < 0.01 * NUMBERS["cj"]
