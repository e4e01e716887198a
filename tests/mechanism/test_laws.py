"""Each law does what its formula promises in a motion that it did not choose: work, memory, nesting."""

from dataclasses import replace

import numpy as np
import pytest

from mechanism.arm import arm_of
from mechanism.cable_lengths import geometry_of_poses, wrap_angles
from mechanism.description import read_neck
from mechanism.law_derivatives import law_derivatives
from mechanism.laws import LAWS, CableMotion, JointMotion, MotorMotion
from mechanism.machine import Machine
from mechanism.simulation import State, simulate
from samples.generator.routes import piece
from tests.paths import NECK_FILE

FILE = NECK_FILE
ARM = arm_of(read_neck(FILE))
BASE = {"k": np.full(4, 8e3), "ca": np.full(4, 60.0), "fs": np.full(4, 15.0), "cm": np.array([0.5])}
NAMES = ("dry_friction", "linear_cable")
TIME = np.arange(0, 0.08, 0.002)
F = 45 + 20 * np.sin(np.outer(TIME, [9.0, 12.0, 7.0, 10.0]))
REST = State(np.zeros(3), np.zeros(3), np.zeros(4), np.zeros(4))


def some(name: str, size: float = 1.0) -> dict[str, np.ndarray]:
    """The law's terms at `size` times what a person would call a change; widths and times, which cannot be zero, at one."""
    values = dict(BASE)
    for term in LAWS[name].terms:
        if term.name not in BASE:
            count = {"cable": 4, "joint": 3, "arm": 1}[term.of]
            values[term.name] = np.full(count, (size if term.low <= 0 else 1.0) * term.size)
    return values


# what slack takes back a simulation never gives: no cable pushes there
EXTRA = [
    name
    for name in LAWS
    if name != "cable_slack" and not {t.name for t in LAWS[name].terms} <= set(BASE) and "modulus" not in name
]


@pytest.mark.parametrize("name", EXTRA)
def test_a_law_is_nested_in_the_base_at_zero_and_moves_the_arm_elsewhere(name: str) -> None:
    base = simulate(Machine(ARM, NAMES, BASE), REST, TIME, F)
    zero, there = (simulate(Machine(ARM, (*NAMES, name), some(name, s)), REST, TIME, F) for s in (0.0, 1.0))
    np.testing.assert_allclose(zero.alpha, base.alpha, atol=1e-7)
    assert np.abs(there.alpha - base.alpha).max() > 1e-6


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_play_whose_flank_is_reached_yields_as_its_spring_and_no_more(side: float) -> None:
    """A motor that presses on: one step off the flank is no crossing, by which a damper would come into the slope of a spring."""
    values = {name: value[:, None] for name, value in (some("backlash") | {"play": np.full(4, 1e-3)}).items()}
    travel_d, length = np.full((4, 1), 0.02 * side), np.ones((4, 1))
    at = CableMotion(np.full((4, 1), 5e-3), np.zeros((4, 1)), length, ARM, travel_d)
    z = np.full((4, 1, 1), side)
    motors, joints = MotorMotion(0 * length, length, length), JointMotion(np.zeros((3, 1)), np.zeros((3, 1)))
    found = law_derivatives(Machine(ARM, (*NAMES, "backlash"), values), at, z, motors, joints)
    np.testing.assert_allclose(found.pull_by_memory, -BASE["k"][0] * 1e-3 / 2, rtol=1e-3)


@pytest.mark.parametrize("name", ["dry_friction", "viscous_friction", "stribeck_friction", "pulley_friction"])
def test_friction_takes_power_and_never_gives(name: str) -> None:
    theta_d = np.linspace(-200, 200, 41)[:, None] * np.ones(4)
    at = MotorMotion(theta_d, np.full((41, 4), 60.0), wrap_angles(ARM, np.zeros(3)) * np.ones((41, 4)))
    power = LAWS[name].friction(some(name), at) * theta_d
    assert power.min() >= 0 < power.max()


def test_cables_that_rub_along_the_arm_take_power_in_all_their_spans_together() -> None:
    """Each of them, whichever way the joints turn; where it slides one way at every pulley, Eytelwein's ratio arrives."""
    route = {"ma": np.full(4, 0.02), "vp": np.array([1e-3]), "wm": np.zeros(1)}
    machine = Machine(ARM, ("pulley_friction",), some("pulley_friction") | route)
    rng = np.random.default_rng(2)
    alpha, alpha_d = rng.uniform(-0.8, 0.8, (2, 200, 3))
    cables = geometry_of_poses(ARM, alpha)
    lost = machine.ratios_lost(cables.Z, alpha_d, cables.wraps)
    assert np.all(np.einsum("tij,tij,ti->tj", cables.Z, lost, alpha_d) > 0)
    for share in (-1.0, -0.3, 0.4, 1.0):  # wherever along the arm they are wound
        elsewhere = replace(machine, values={**machine.values, "wm": np.array([share])})
        lost = elsewhere.ratios_lost(cables.Z, alpha_d, cables.wraps)
        assert np.all(np.einsum("tij,tij,ti->tj", cables.Z, lost, alpha_d) > -1e-12)
    fast = machine.ratios_lost(cables.Z, 1e4 * np.sign(cables.Z[..., 0]) * np.array([1.0, 0.0, 0.0]), cables.wraps)
    np.testing.assert_allclose(1 - fast[:, 0, 0], np.exp(-0.02 * cables.wraps[:, 0, 0]), rtol=1e-6)


def test_friction_that_bends_loses_energy_in_a_cycle_as_bristles_and_dry_friction_do() -> None:
    """The integral of friction dtheta over a long stroke and back: twice the stroke times the force, less what bends hold back."""
    machine = Machine(ARM, ("dry_friction", "presliding_friction"), {
        "fs": np.full(4, 12.0), "cm": np.array([0.5]), "fp": np.full(4, 12.0), "wp": np.full(4, 0.03),
    })  # fmt: skip
    stroke = 3.0
    there = np.linspace(0, stroke, 20001)
    path = np.concatenate([there, there[-2::-1], there[1:]])[:, None] * np.ones(4)
    speed = np.diff(path, axis=0) * 1e3
    at = MotorMotion(speed, np.zeros(()), np.zeros(()), memory=machine.memory_on_path(path))
    force = machine.friction(at)[:, 0]
    once_around = slice(20000, 60000)
    work = float(np.sum(force[once_around] * np.diff(path[:, 0])[once_around]))
    # along each way it is 12 (1 - 2 exp(-s / w)): what is missing is 24 w
    np.testing.assert_allclose(work, 2 * (12 * stroke - 24 * 0.03), rtol=1e-4)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_step_knows_how_friction_bends(side: float) -> None:
    """Slopes by the memory and by the motor's speed: of fp z and of (theta' - |theta'| z) / wp."""
    values = {name: value[:, None] for name, value in (some("presliding_friction") | {"fp": np.full(4, 9.0)}).items()}
    length, theta_d, z = np.ones((4, 1)), np.full((4, 1), 5.0 * side), np.full((4, 1, 1), 0.25)
    at = CableMotion(0.01 * length, 0 * length, length, ARM, ARM.drum[:, None] * theta_d)
    machine = Machine(replace(ARM, drum=ARM.drum[:, None]), (*NAMES, "presliding_friction"), values)
    at = replace(at, arm=machine.arm)
    motors, joints = MotorMotion(theta_d, length, length), JointMotion(np.zeros((3, 1)), np.zeros((3, 1)))
    found = law_derivatives(machine, at, z, motors, joints)
    np.testing.assert_allclose(found.friction_by_memory, 9.0, rtol=1e-5)
    np.testing.assert_allclose(found.memory_rate_by_speed, (1 - side * 0.25) / values["wp"][..., None], rtol=1e-5)


@pytest.mark.parametrize("name", ["cable_hysteresis", "cable_creep"])
def test_a_cable_that_remembers_loses_energy_in_a_cycle(name: str) -> None:
    """The integral of pull dx over closed cycles, after the first: the area of the loop is positive."""
    values, law, h = some(name), LAWS[name], 1e-3
    t = np.arange(0, 20, h)
    x, x_d = 0.006 + 0.003 * np.sin(2 * np.pi * t), 0.006 * np.pi * np.cos(2 * np.pi * t)
    z, work = np.zeros((4, 1)), 0.0
    for k in range(len(t)):
        at = CableMotion(np.full(4, x[k]), np.full(4, x_d[k]), np.ones(4), ARM, np.zeros(4))
        if t[k] >= 10:
            work += float(law.pull(values, at, z)[0] * x_d[k] * h)
        z = z + h * law.memory_rate(values, at, z)
    assert work > 1e-4


@pytest.mark.parametrize("name", ["actuator_gain", "actuator_offset", "actuator_lag"])
def test_what_is_written_for_a_force_makes_that_force(name: str) -> None:
    values, law = some(name, 3.0), LAWS[name]
    np.testing.assert_allclose(law.acting_force(values, law.commanded_force(values, F, 0.002), 0.002), F, atol=1e-9)
    assert np.abs(law.acting_force(values, F, 0.002) - F).max() > 0.1


@pytest.mark.parametrize("lag", [0.0005, 0.002, 0.02])
def test_a_force_that_follows_late_is_late_by_its_time(lag: float) -> None:
    """In the mean over rows: by the area between a step and what acts, whatever a row is beside the lag."""
    f, step = np.concatenate([np.zeros((1, 4)), np.ones((400, 4))]), 0.002
    acts = LAWS["actuator_lag"].acting_force({"taul": np.full(4, lag)}, f, step)
    np.testing.assert_allclose(step * np.sum(f - acts, axis=0), lag, rtol=1e-6)
    assert np.all(np.diff(acts, axis=0) >= 0)


def test_a_long_lag_comes_nearer_by_e_in_its_time() -> None:
    f = np.concatenate([np.zeros((1, 4)), np.ones((400, 4))])
    acts = LAWS["actuator_lag"].acting_force({"taul": np.array([0.2])}, f, 0.002)
    np.testing.assert_allclose(1 - acts[100], np.exp(-1), rtol=0.01)


def test_backlash_is_half_the_play_behind_on_either_side() -> None:
    """The pull lacks k play/2 once the drum has turned far one way, and has as much more the other way."""
    values = {"k": np.full(4, 8e3), "ca": np.full(4, 50.0), "play": np.full(4, 1e-3), "pb": np.array([0.5])}
    law, z = LAWS["backlash"], np.zeros((4, 1))
    for way in (1.0, -1.0):
        at = CableMotion(np.full(4, 0.01), np.zeros(4), np.ones(4), ARM, np.full(4, way * 0.02))
        for _ in range(2000):
            z = np.clip(z + 1e-3 * law.memory_rate(values, at, z), -1, 1)
        np.testing.assert_allclose(law.pull(values, at, z), -way * 4.0, rtol=1e-6)


def test_creep_relaxes_with_its_time_constant() -> None:
    """After a step of the elongation the pull falls from km x to nothing, by 1/e in tau."""
    values = {"km": np.full(4, 500.0), "tau": np.array([2.0])}
    z = np.full((4, 1), 5.0)
    at = CableMotion(np.full(4, 0.01), np.zeros(4), np.ones(4), ARM, np.zeros(4))
    for _ in range(2000):
        z = z + 1e-3 * LAWS["cable_creep"].memory_rate(values, at, z)
    np.testing.assert_allclose(z, 5.0 * np.exp(-1), rtol=1e-3)


@pytest.mark.parametrize("sooner", [1.0, 2.0, 2.7, 8.0])
def test_dry_friction_of_joints_is_the_same_both_ways_and_never_more_than_whole(sooner: float) -> None:
    speed = np.linspace(-4, 4, 801)[:, None] * np.ones(3)
    values = {"cj": np.full(3, 0.02), "dj": np.zeros(3), "vj": np.array([0.1]), "nj": np.array([sooner])}
    found = LAWS["joint_friction"].resistance(values, JointMotion(0 * speed, speed))
    np.testing.assert_allclose(found, -found[::-1], atol=1e-15)
    assert np.all(np.diff(found, axis=0) >= 0)
    assert np.all(np.abs(found) <= 0.02)
    # with n a forty-first of it is wanting at most at forty widths; at rest it rises by one in a width
    assert np.all(found[-1] > 0.02 * 40 / 41 * (1 - 1e-12))
    near = LAWS["joint_friction"].resistance(values, JointMotion(np.zeros(3), np.full(3, 1e-7)))
    np.testing.assert_allclose(near, 0.02 * 1e-7 / 0.1, rtol=1e-5)
    if sooner == 2.7:
        np.testing.assert_allclose(found, 0.02 * np.tanh(speed / 0.1), atol=0.02 * 0.02)


def test_toe_ends_at_the_cables_own_stiffness() -> None:
    values = {"k": np.full(4, 8e3), "ca": np.zeros(4), "xt": np.full(4, 1e-3)}

    def pull(x: float) -> float:
        at = CableMotion(np.full(4, x), np.zeros(4), np.ones(4), ARM, np.zeros(4))
        return float(Machine(ARM, ("linear_cable", "cable_toe"), values).tension(at, np.zeros((4, 0)))[0])

    assert (pull(1e-5) - pull(0.0)) / 1e-5 < 100 < 7900 < (pull(0.0101) - pull(0.01)) / 1e-4


def test_wraps_are_those_of_taut_strings() -> None:
    """By another construction: tangents of circles and the angles wound between them."""
    alpha = np.random.default_rng(0).uniform(-0.6, 0.6, (20, 3))
    expected = np.zeros((20, 4))
    for j, route in enumerate(ARM.routes):
        for i, word in enumerate(route):
            string = piece(word, alpha[:, i], ARM.L[i], ARM.b[i], ARM.r[i]).string
            radii = np.array([w.radius > 0 for w in string.wheels])
            expected[:, j] += string.wound @ radii
    np.testing.assert_allclose(wrap_angles(ARM, alpha), expected, atol=1e-12)


def test_what_is_wound_around_pulleys_of_an_upper_bar_slides_as_the_cable_above() -> None:
    """Taut strings again: of each mechanism's pulleys the first is on its lower bar."""
    alpha = np.random.default_rng(1).uniform(-0.6, 0.6, (20, 3))
    expected = np.zeros((20, 6, 4))
    for j, route in enumerate(ARM.routes):
        for i, word in enumerate(route):
            string = piece(word, alpha[:, i], ARM.L[i], ARM.b[i], ARM.r[i]).string
            first, *above = (w.radius > 0 for w in string.wheels)
            expected[:, i, j] += string.wound[:, 0] * first
            expected[:, 3 + i, j] += string.wound[:, 1:] @ np.array(above)
    np.testing.assert_allclose(geometry_of_poses(ARM, alpha).wraps, expected, atol=1e-12)
