"""The arm that is written for MuJoCo moves in MuJoCo as it does in `mechanism`, and each law is in it or refused by its name."""

# mujoco comes without complete type stubs
# pyright: reportAttributeAccessIssue=false

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from mechanism.cable_lengths import lengths
from mechanism.laws import LAWS, JointMotion, law_named
from mechanism.laws.unlisted import unlisted_laws
from mechanism.machine import Machine
from mechanism.mjcf.bodies import joint_coordinates
from mechanism.mjcf.document import STEP_S, mjcf
from mechanism.mjcf.law_elements import REFUSALS, WRITTEN
from mechanism.mjcf.ramps import TOLERANCE, ramps_of
from tests.mechanism.mjcf.three_arms import ARMS, ROW_S, Driven, sample_arm
from xneck_foundation.errors import Refused

BOUND_RAD = float(np.radians(0.1))
"""rms of all joint angles over 10 s of swings of 40 to 90 deg with taut cables; docs/export.md states it"""


class InMujoco:
    """The written arm in MuJoCo."""

    def __init__(self, machine: Machine, step: float = STEP_S) -> None:
        self.arm = machine.arm
        self.model = mujoco.MjModel.from_xml_string(mjcf(machine, step))
        self.data = mujoco.MjData(self.model)

    def place(self, alpha: np.ndarray) -> None:
        """At rest at joint angles alpha (N,), rad, with theta = 0."""
        for i, coordinates in enumerate(joint_coordinates(self.arm, alpha)):
            for name, value in zip(("A", "bar", "B"), coordinates, strict=True):
                self.data.joint(f"{name}{i + 1}").qpos = value
        mujoco.mj_forward(self.model, self.data)

    def sensed(self, stem: str, count: int) -> np.ndarray:
        return np.array([self.data.sensor(f"{stem}{i + 1}").data[0] for i in range(count)])

    def play(self, forces: np.ndarray) -> np.ndarray:
        """Joint angles (T, N), rad, at rows of which each one's forces are held to the next."""
        alpha, steps = [], round(ROW_S / self.model.opt.timestep)
        for f in forces:
            mujoco.mj_forward(self.model, self.data)
            alpha.append(self.sensed("alpha", self.arm.N))
            self.data.ctrl[: self.arm.M] = f
            for _ in range(steps):
                mujoco.mj_step(self.model, self.data)
        return np.array(alpha)


def swing(driven: Driven, seconds: float, step: float = STEP_S) -> np.ndarray:
    bodies = InMujoco(driven.machine, step)
    bodies.place(driven.start)
    return bodies.play(driven.forces(seconds))


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("name", ARMS)
def test_cables_are_as_long_as_the_pulley_model_says(name: str) -> None:
    """In any pose, but for a constant: to rounding. Loops are closed there too, and tensions are the laws'."""
    driven = ARMS[name]()
    bodies, arm = InMujoco(driven.machine), driven.machine.arm
    cables = [bodies.model.tendon(f"cable{j + 1}").id for j in range(arm.M)]
    bodies.place(np.zeros(arm.N))
    straight, random = bodies.data.ten_length[cables].copy(), np.random.default_rng(0)
    for alpha in random.uniform(-1.4, 1.4, (50, arm.N)):
        bodies.place(alpha)
        expected = lengths(arm, alpha) - lengths(arm, np.zeros(arm.N))
        assert bodies.data.ten_length[cables] - straight == pytest.approx(expected, abs=1e-12)
        assert bodies.sensed("alpha", arm.N) == pytest.approx(alpha, abs=1e-12)
        ends = [
            bodies.data.site(f"end_B{i + 1}").xpos - bodies.data.site(f"top_left{i + 1}").xpos for i in range(arm.N)
        ]
        assert np.abs(ends).max() < 1e-12
        if name == "sample":  # linear cables
            x = np.maximum(expected + arm.x0, 0.0)
            assert -bodies.sensed("minus_tension", arm.M) == pytest.approx(driven.machine.values["k"] * x, abs=1e-7)


@pytest.mark.parametrize(
    ("name", "seconds", "max_step"),
    [
        *((name, 1.0, 5e-4) for name in ARMS),
        *(pytest.param(name, 10.0, 1e-3, marks=pytest.mark.slow) for name in ARMS),
    ],
)
def test_it_moves_as_the_simulation_does(name: str, seconds: float, max_step: float) -> None:
    driven = ARMS[name]()
    reference, written = driven.by_xneck(seconds, max_step).alpha, swing(driven, seconds)
    assert np.ptp(reference, axis=0).min() > 0.2, "the arm swings wide enough to feel every term"
    assert rms(written - reference) < BOUND_RAD


@pytest.mark.slow
def test_what_differs_shrinks_with_the_step() -> None:
    """The error is MuJoCo's integration, in proportion to its step, and the ramps' share of the friction: nothing is left beside.

    What the ramps may do is what friction that is larger by their tolerance does.
    """
    driven = sample_arm()
    reference = driven.by_xneck(0.6, 1.25e-4).alpha
    coarse, fine = (rms(swing(driven, 0.6, step) - reference) for step in (4e-4, 1e-4))
    values = dict(driven.machine.values) | {"fs": driven.machine.values["fs"] * (1 + TOLERANCE)}
    rubbing = replace(driven, machine=replace(driven.machine, values=values)).by_xneck(0.6, 1.25e-4).alpha
    by_ramps = rms(rubbing - reference)
    assert fine < coarse / 4 + by_ramps
    assert coarse < BOUND_RAD


@pytest.mark.parametrize(("term", "factor"), [("k", 1.1), ("fs", 1.1)])
def test_another_number_breaks_the_bound(term: str, factor: float) -> None:
    driven = sample_arm()
    values = dict(driven.machine.values) | {term: driven.machine.values[term] * factor}
    wrong = replace(driven, machine=replace(driven.machine, values=values))
    assert rms(swing(wrong, 0.8) - driven.by_xneck(0.8).alpha) > BOUND_RAD


def test_cables_that_come_taut_little_by_little_pull_as_the_law_says() -> None:
    """Softly where they are a little longer than their way, and never with less than nothing; to what a ramp may be off."""
    driven = sample_arm()
    xs = np.array([1e-3, 3e-4, 1e-6, 7e-4])
    values = {**driven.machine.values, "slack": np.ones(4), "xs": xs}
    machine = replace(driven.machine, names=(*driven.machine.names, "cable_slack"), values=values)
    bodies, arm, k = InMujoco(machine), machine.arm, values["k"]
    straight = lengths(arm, np.zeros(arm.N))
    loose = 0
    for alpha in np.random.default_rng(0).uniform(-0.3, 0.3, (50, arm.N)):
        bodies.place(alpha)
        x = lengths(arm, alpha) - straight + arm.x0
        loose += np.sum(np.abs(x) < xs)
        expected = k * xs * np.logaddexp(0.0, x / xs)
        assert -bodies.sensed("minus_tension", arm.M) == pytest.approx(expected, rel=2e-3, abs=0.02)
    assert loose > 5


def test_an_actuator_with_a_lag_follows_its_command() -> None:
    """The force after a step of the command is 1 - exp(-t/taul) of it."""
    driven = sample_arm()
    machine = replace(driven.machine, names=(*driven.machine.names, "actuator_lag"))
    lagging = InMujoco(replace(machine, values={**machine.values, "taul": np.array([0.03])}))
    lagging.data.ctrl[:4] = 50.0
    for _ in range(round(0.06 / STEP_S)):
        mujoco.mj_step(lagging.model, lagging.data)
    assert lagging.data.actuator("motor1").force[0] == pytest.approx(50 * (1 - np.exp(-2)), rel=0.01)


def test_every_law_is_written_or_refused_by_name() -> None:
    assert sorted((*WRITTEN, *REFUSALS)) == sorted(LAWS)
    driven = sample_arm()
    not_followed = [name for name, law in unlisted_laws().items() if law.variable.name in ("time", "motor_angle")]
    for name in (*REFUSALS, *not_followed[::20]):
        machine = replace(driven.machine, names=(*driven.machine.names, name))
        with pytest.raises(Refused, match=f"{re.escape(name)}: MuJoCo"):
            mjcf(machine)


def test_what_spans_joints_is_refused_by_name() -> None:
    driven, name = sample_arm(), "joint.hinge.joint_angle.over_1_to_2"
    with pytest.raises(Refused, match=f"{re.escape(name)}: it is written for single joints only"):
        mjcf(replace(driven.machine, names=(*driven.machine.names, name)))


def test_a_law_that_nobody_listed_is_written_where_it_follows_a_speed_or_an_angle() -> None:
    """Torque against the joints by their angle: MuJoCo's acceleration at rest differs from that without the law by it."""
    driven = sample_arm()
    name = next(name for name, law in unlisted_laws().items() if law.variable.name == "joint_angle")
    law = unlisted_laws()[name]
    amounts = {term.name: np.full(3, 0.05) for term in law.amount_terms}
    constants = {term.name: np.ones(1) for term in law.constant_terms}
    machine = replace(driven.machine, names=(*driven.machine.names, name))
    machine = replace(machine, values={**machine.values, **amounts, **constants})
    alpha = np.array([0.4, -0.3, 0.2])
    forces = []
    for each in (driven.machine, machine):
        bodies = InMujoco(each)
        bodies.place(alpha)
        forces.append(bodies.data.qfrc_actuator[[bodies.model.joint(f"bar{i + 1}").dofadr[0] for i in range(3)]])
    expected = law_named(name).resistance(machine.values, JointMotion(alpha, np.zeros(3)))
    assert np.abs(expected).max() > 1e-3
    assert forces[0] - forces[1] == pytest.approx(expected, abs=2e-3 * np.abs(expected).max() + 1e-9)


def test_a_motor_without_inertia_is_refused() -> None:
    driven = sample_arm()
    arm = replace(driven.machine.arm, motor_inertia=np.array([5e-6, 0.0, 5e-6, 5e-6]))
    with pytest.raises(Refused, match="motor 2 has no inertia"):
        mjcf(replace(driven.machine, arm=arm))


def test_a_cable_without_stiffness_is_refused() -> None:
    """A stiffness that was estimated below zero is taken as zero: such an arm would hang on nothing in MuJoCo."""
    machine = sample_arm().machine
    values = {**machine.values, "k": np.array([9e3, 9e3, 0.0, 9e3])}
    with pytest.raises(Refused, match="cable 3 has no stiffness"):
        mjcf(replace(machine, values=values))


@pytest.mark.parametrize("low", [-20.0, 0.0])
def test_ramps_follow_a_function(low: float) -> None:
    def function(v: np.ndarray) -> np.ndarray:
        return 2 + np.arctan(v) - 0.3 * v * np.exp(-v / 5) + 0.01 * v**2

    constant, ramps = ramps_of(function, low, 30.0)
    v = np.linspace(low, 30.0, 2003)
    error = constant + sum(ramp.at(v) for ramp in ramps) - function(v)
    assert np.abs(error).max() < 1.5 * TOLERANCE * np.abs(function(v)).max()
    assert 5 < len(ramps) < 200
    beyond = constant + sum(ramp.at(np.array([50.0])) for ramp in ramps)
    assert beyond == pytest.approx(function(np.array([30.0])), abs=2 * TOLERANCE * np.abs(function(v)).max())
