"""Laws that no catalogue lists: every one there may be, by its name, in forces and in motion."""

from dataclasses import replace

import numpy as np
import pytest

from mechanism.arm import arm_of
from mechanism.description import read_neck
from mechanism.friction import dry
from mechanism.laws import LAWS, CableMotion, JointMotion, MotorMotion, is_law, law_named
from mechanism.laws.unlisted import COPIES, UnlistedLaw, law_name, unlisted_laws
from mechanism.machine import Machine
from mechanism.simulation import simulate, simulate_given_angles
from tests.mechanism.runge_kutta import runge_kutta
from tests.mechanism.test_simulation import ARM, MACHINE, TIME, VALUES, moving
from tests.paths import NECK_FILE

CONSTANTS = {
    "count": 7.0, "exponent": 1.5, "size": 50.0, "tau": 0.1, "begin": 0.0, "place": 0.05, "side": 1.0,
    "level": 30.0, "width": 0.5, "low": -1.0, "high": 1.0, "wavenumber": 16.0,
}  # fmt: skip


def _each_once() -> list[str]:
    """Names of laws among which are all variables with all factors, and all forms: one part of a law knows nothing of the other."""
    variables, forms, out = set(), set(), []
    for name, law in unlisted_laws().items():
        form = (law.form.name, law.form.kinds, len(law.amount_terms))
        is_there = law.variable.joints <= ARM.N and name == law_name(law.variable, law.form)
        if is_there and (law.variable not in variables or form not in forms):
            variables.add(law.variable)
            forms.add(form)
            out.append(name)
    return out


EACH_ONCE = _each_once()


def with_law(name: str, size: float) -> Machine:
    """The machine with a law whose amounts are all of a size, in what a person would call a change."""
    law = unlisted_laws()[name]
    count = law.amount_terms[0].count(ARM)
    amounts = np.array([np.full(count, size * term.size) for term in law.amount_terms])
    if law.form.name == "polynomial":  # of forces of 50 N, and angles of 0.1 rad
        x = {"N": 50.0, "rad": 0.2, "rad/s": 20.0 if law.variable.acts == "motor" else 1.0, "s": 1.0}[law.variable.unit]
        amounts = amounts / np.array([[x**n] for n in range(1, len(amounts) + 1)])
    there = {"place": 25.0, "width": 20.0} if law.variable.unit == "N" else {}
    constants = {name: (CONSTANTS | there)[name] for name in law.form.constants}
    return Machine(ARM, (*MACHINE.names, name), VALUES | law.values(amounts, constants))


def test_names_are_of_one_law_each_and_of_no_listed_one() -> None:
    terms = [term.name for law in unlisted_laws().values() for term in law.terms]
    assert len(terms) == len(set(terms))
    assert not set(unlisted_laws()) & set(LAWS)
    assert is_law("motor.harmonic.motor_angle")
    assert not is_law("motor.harmonic.moon")
    assert law_named("cable_creep") is LAWS["cable_creep"]


@pytest.mark.parametrize("name", EACH_ONCE)
def test_a_law_does_nothing_at_zero_and_moves_the_arm_elsewhere(name: str) -> None:
    start, f = moving(30)
    base = simulate(MACHINE, start, TIME[:30], f)
    zero, there = (simulate(with_law(name, size), start, TIME[:30], f) for size in (0.0, 1.0))
    np.testing.assert_allclose(zero.alpha, base.alpha, atol=1e-12)
    assert np.abs(there.theta - base.theta).max() > 1e-7


@pytest.mark.parametrize(
    "name",
    [
        "motor.harmonic.motor_angle",
        "motor.power.tension.along",
        "motor.levelling_off.force",
        "motor.exponential.time.along",
        "encoder.harmonic.motor_angle",
        "cable.harmonic.drum_angle",
        "cable.harmonic.motor_angle",
        "cable.exponential.time",
        "joint.hinge.joint_angle",
        "joint.wave.joint_angle",
        "joint.hinge.joint_angle.over_1_to_2",
        "joint.polynomial.joint_angle.over_2_to_3.degree1",
        "joint.power.joint_speed",
    ],
)
def test_simulated_motions_are_those_of_runge_and_kutta(name: str) -> None:
    """Of a window that begins 3 s after its recording: the error falls with the step as it does without the law."""
    machine, (start, f) = with_law(name, 1.0), moving(40)
    exact = runge_kutta(machine, start, TIME[:40], f, 2e-4, began=-0.1)[-1]
    errors = [
        np.max(np.abs(simulate(machine, start, TIME[:40], f, h, began=-0.1).alpha[-1] - exact.alpha))
        for h in (2e-3, 5e-4)
    ]
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 4


def test_windows_that_begin_at_different_times_are_a_batch() -> None:
    machine, (start, f) = with_law("motor.exponential.time.along", 3.0), moving(30)
    began = np.array([0.0, -0.2])
    together = simulate(machine, start, TIME[:30], f, began=began)
    for i, alone in enumerate(began):
        np.testing.assert_allclose(together.alpha[i], simulate(machine, start, TIME[:30], f, began=alone).alpha)
    assert np.abs(together.alpha[0] - together.alpha[1]).max() > 1e-5


def test_motors_that_are_led_ask_for_the_force_that_friction_by_force_takes() -> None:
    """Forces that lead to a motion, and the force that the led motion asks for, differ by no more than a step's error."""
    machine, (start, f) = with_law("motor.polynomial.force.degree1", 4.0), moving(60)
    free = simulate(machine, start, TIME[:60], f)
    theta_dd = np.gradient(free.theta_d, TIME[:60], axis=0)
    led = simulate_given_angles(machine, start, TIME[:60], (free.theta, free.theta_d, theta_dd))
    plain = simulate_given_angles(MACHINE, start, TIME[:60], (free.theta, free.theta_d, theta_dd))
    asked = (led.f - plain.f)[10:-10]
    # a share of 4/50 of the force, of which it asks for itself too
    np.testing.assert_allclose(asked, 0.08 * led.f[10:-10], rtol=1e-3)


@pytest.mark.parametrize("copy", range(1, COPIES + 1))
def test_copies_of_a_law_add_up(copy: int) -> None:
    name = "motor.harmonic.motor_angle" + (f".{copy}" if copy > 1 else "")
    law = unlisted_laws()[name]
    at = MotorMotion(*(np.ones(4) for _ in range(3)), theta=np.array([0.1, 0.2, 0.3, 0.4]))
    values = law.values(np.array([[0.0] * 4, [2.0] * 4]), {"count": float(copy)})
    np.testing.assert_allclose(law.friction(values, at), 2 * np.sin(copy * at.theta))


def test_along_the_motion_a_law_has_the_sign_of_dry_friction() -> None:
    law: UnlistedLaw = unlisted_laws()["motor.polynomial.tension.along.degree1"]
    speed, tension = np.array([-20.0, -0.1, 0.1, 20.0]), np.array([10.0, 20, 30, 40])
    values = law.values(np.full((1, 4), 0.02), {}) | {"cm": np.array([0.5])}
    found = law.friction(values, MotorMotion(speed, tension, np.zeros(4)))
    np.testing.assert_allclose(found, 0.02 * tension * dry(speed))


def test_a_hinge_holds_the_joint_beyond_its_place_only() -> None:
    law = unlisted_laws()["joint.hinge.joint_angle"]
    values = law.values(np.full((1, 3), 0.4), {"place": 0.1, "side": 1.0})
    found = law.resistance(values, JointMotion(np.array([0.0, 0.1, 0.3]), np.zeros(3)))
    np.testing.assert_allclose(found, [0.0, 0.0, 0.08])


def test_the_gear_of_the_drawing_turns_the_drum() -> None:
    neck = read_neck(NECK_FILE)
    assert arm_of(neck).gear.tolist() == [motor.R for motor in neck.motors]


@pytest.mark.parametrize("name", EACH_ONCE)
def test_a_batch_of_numbers_moves_as_each_alone(name: str) -> None:
    """Amounts and inner constants of a batch differ, as where a simulation's sigma is told."""
    one, (start, f) = with_law(name, 1.0), moving(6)
    law = unlisted_laws()[name]
    other = {k: v * 1.1 if k.startswith(law.name) else v for k, v in one.values.items()}
    both = Machine(ARM, one.names, {k: np.stack([v, other[k]]) for k, v in one.values.items()})
    together = simulate(both, start, TIME[:6], f)
    for i, values in enumerate((one.values, other)):
        alone = simulate(Machine(ARM, one.names, values), start, TIME[:6], f)
        np.testing.assert_allclose(together.alpha[i], alone.alpha, atol=1e-12)


@pytest.mark.parametrize("variable", ["drum_angle", "motor_angle"])
def test_a_drum_that_winds_unevenly_does_no_work_of_its_own(variable: str) -> None:
    """By virtual work: what the motor feels is the slope of the elastic energy, by central differences."""
    machine = with_law(f"cable.harmonic.{variable}", 3.0)
    law, drum, gear, k = law_named(f"cable.harmonic.{variable}"), ARM.drum, ARM.gear, VALUES["k"]
    values = {**machine.values, "ca": np.zeros(1)}
    theta = np.random.default_rng(0).uniform(-60.0, 60.0, (50, 4))
    nothing, rest = np.zeros_like(theta), 0.004

    def pulled(theta: np.ndarray) -> np.ndarray:
        x = rest + drum * theta
        at = CableMotion(x, nothing, nothing, ARM, nothing, theta / gear, theta)
        return k * x + law.pull(values, at, np.zeros((*theta.shape, 0)))

    h = 1e-4
    slope = (pulled(theta + h) ** 2 - pulled(theta - h) ** 2) / (2 * k) / (2 * h)
    tension = pulled(theta)
    felt = tension + law.friction(values, MotorMotion(nothing, tension, nothing, theta, theta / gear, arm=ARM))
    assert np.abs(felt - tension).max() > 0.1 * np.abs(tension).max() / 5, "the lever differs"
    np.testing.assert_allclose(felt * drum, slope, rtol=0, atol=1e-5 * np.abs(felt * drum).max())


@pytest.mark.parametrize(("first", "last"), [(1, 2), (2, 3), (1, 3)])
def test_what_spans_joints_bends_each_of_them_as_its_energy_falls(first: int, last: int) -> None:
    """Torques are the slope of an energy of the sum of the angles, by central differences; joints beside it feel nothing."""
    law = law_named(f"joint.hinge.joint_angle.over_{first}_to_{last}")
    assert isinstance(law, UnlistedLaw)
    stiffness, place = 0.7, 0.05
    values = law.values(np.full((1, 1), stiffness), {"place": place, "side": 1.0})

    def energy(alpha: np.ndarray) -> float:
        return stiffness / 2 * max(alpha[first - 1 : last].sum() - place, 0.0) ** 2

    alpha, h = np.array([0.1, 0.2, -0.05]), 1e-6
    slope = [(energy(alpha + h * e) - energy(alpha - h * e)) / (2 * h) for e in np.eye(3)]
    np.testing.assert_allclose(law.resistance(values, JointMotion(alpha, np.zeros(3))), slope, atol=1e-8)
    assert np.count_nonzero(slope) == last - first + 1


def test_an_arm_whose_encoders_read_wrongly_moves_as_it_would_without_them() -> None:
    """The same motion, once by true angles with the base laws, once by what encoders read of them with the law of their error."""
    name, steps = "encoder.harmonic.motor_angle", 60
    size, count, phase = 0.03, 2.0, 0.7
    law = unlisted_laws()[name]
    start, f = moving(steps)
    true = simulate(MACHINE, start, TIME[:steps], f, 5e-4)

    def error(theta: np.ndarray) -> np.ndarray:
        return size * np.sin(count * theta + phase)

    read = true.theta + error(true.theta)
    slope = size * count * np.cos(count * start.theta + phase)
    amounts = size * np.array([[np.sin(phase)] * 4, [np.cos(phase)] * 4])
    begins = replace(start, theta=read[0], theta_d=start.theta_d * (1 + slope))
    machine = Machine(ARM, (*MACHINE.names, name), VALUES | law.values(amounts, {"count": count}))
    moved, believed = (simulate(m, begins, TIME[:steps], f, 5e-4) for m in (machine, MACHINE))
    off = [np.abs(m.theta - read).max() for m in (moved, believed)]
    turned = [np.abs(m.alpha - true.alpha).max() for m in (moved, believed)]
    assert off[0] < 0.02 * off[1]
    assert turned[0] < 0.02 * turned[1]
