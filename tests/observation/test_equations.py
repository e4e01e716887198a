"""Equations that were traced from mechanism's formulas: the same numbers, derivatives by differences, and a law that has none."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mechanism.arm import arm_of
from mechanism.description import read_neck
from mechanism.dynamics import terms
from mechanism.laws import LAWS
from mechanism.laws.unlisted import unlisted_laws
from mechanism.machine import Machine
from mechanism.simulation import State, simulate
from observation.equations import traced_equations
from observation.expression import OPERATIONS, Derivatives, apply, as_expression, variable
from observation.generated_code import python_function
from observation.observer import Observer
from observation.tracing import Untraceable, symbols
from tests.observation.arms import base_model
from tests.paths import SAMPLES

NECK = read_neck(SAMPLES / "recording/neck.yaml")
POINTS = {
    "sqrt": (0.7,), "log": (0.7,), "arccos": (0.3,), "arcsin": (0.3,), "power": (1.3, 2.5), "arctan2": (0.4, -0.7),
    "where": (1.0, 0.4, 0.9), "divide": (0.4, 0.9),
}  # fmt: skip


def arm_and_values(names: tuple[str, ...]) -> Machine:
    """An arm of the generator with laws of the size that a person would call a change."""
    arm = arm_of(NECK)
    values = {}
    for name in names:
        law = LAWS[name] if name in LAWS else unlisted_laws()[name]
        for term in law.terms:
            values[term.name] = np.full(term.count(arm), {"k": 8e3, "cm": 0.5, "fs": 14.0}.get(term.name, term.size))
    return Machine(arm, names, values)


@pytest.mark.parametrize("operation", sorted(set(OPERATIONS) - {"sign", "greater"}))
def test_derivatives_of_operations_are_their_slopes(operation: str) -> None:
    count = {"where": 3}.get(operation, len(POINTS.get(operation, ())) or _arity(operation))
    at = POINTS.get(operation, (0.37, -0.61)[:count])
    inputs = [variable(f"x{i}") for i in range(count)]
    e = apply(operation, *inputs)
    value = python_function([[v.name for v in inputs]], [e])
    first = 1 if operation == "where" else 0
    for i in range(first, 1 if operation == "power" else count):
        slope = python_function([[v.name for v in inputs]], [Derivatives(inputs[i]).of(e)])(at)[0]
        up, down = (tuple(x + s * (k == i) for k, x in enumerate(at)) for s in (1e-6, -1e-6))
        assert slope == pytest.approx((value(up)[0] - value(down)[0]) / 2e-6, rel=1e-5, abs=1e-8)


def _arity(operation: str) -> int:
    try:
        OPERATIONS[operation](0.3)
    except TypeError:
        return 2
    return 1


@pytest.mark.parametrize(
    "name",
    [
        *sorted(LAWS),
        "motor.bump.motor_angle.along",
        "joint.saturating.joint_speed",
        "motor.smooth.tension",
        "cable.smooth.drum_angle",
    ],
)
def test_every_law_can_be_written_as_code_with_its_derivatives(name: str) -> None:
    base = ("dry_friction", "linear_cable")
    machine = arm_and_values(base if name in base else (*base, name))
    if name == "motor.smooth.tension":
        low, high = (next(k for k in machine.values if k.endswith(f".{end}")) for end in ("low", "high"))
        machine.values[low][:], machine.values[high][:] = 0.0, 80.0  # type: ignore[index]
    e = traced_equations(machine)
    layout, rng = e.layout, np.random.default_rng(3)
    s = rng.uniform(-0.3, 0.3, layout.size)
    s[layout.x0], s[layout.theta_d] = 4e-3, rng.uniform(-8, 8, layout.M)
    s[layout.theta], s[layout.alpha] = 0.05 * s[layout.theta], 0.05 * s[layout.alpha]
    evaluated = python_function([[v.name for v in e.state], [v.name for v in e.force], [e.time.name]], e.outputs)
    first, count = layout.N**2, len(e.rates)

    def rates(state: np.ndarray) -> np.ndarray:
        return np.array(evaluated(state.tolist(), [20.0] * layout.M, (1.0,)))[first : first + count]

    values = np.array(evaluated(s.tolist(), [20.0] * layout.M, (1.0,)))
    J = np.zeros((count, layout.size))
    for (row, column), value in zip(e.places, values[first + count :], strict=False):
        J[row, column] = value
    own = machine.arm
    coriolis = terms(own, s[layout.alpha], s[layout.alpha_d]).c
    assert np.abs(coriolis).max() < 0.05 * np.abs(rates(s)[: layout.N]).max()
    for column in range(layout.friction_error.stop):
        step = 1e-6 * max(1.0, abs(s[column])) if column not in range(*layout.x0.indices(99)) else 1e-8
        up, down = s.copy(), s.copy()
        up[column] += step
        down[column] -= step
        slope = (rates(up) - rates(down)) / (2 * step)
        if column < layout.theta.start:  # derivatives leave out those of c
            slope[: layout.N] += (_coriolis(machine, up, layout) - _coriolis(machine, down, layout)) / (2 * step)
        np.testing.assert_allclose(J[:, column], slope, rtol=2e-4, atol=1e-4 * max(1.0, np.abs(slope).max()))


def _coriolis(machine: Machine, s: np.ndarray, layout: object) -> np.ndarray:
    return terms(machine.arm, s[layout.alpha], s[layout.alpha_d]).c  # type: ignore[attr-defined]


def test_the_filters_step_is_the_simulations() -> None:
    """Without a measurement the filter goes the way that the simulation goes, which is integrated with steps a tenth as long."""
    observer = Observer(NECK, base_model(NECK, np.full(4, 8e3)))
    numbers, layout = observer.numbers, observer.numbers.layout
    observer.step(np.zeros(4), np.full(4, 25.0))
    s, acceleration = observer.state.copy(), np.zeros(layout.size)
    s[layout.theta_d] = [8.0, -6.0, 5.0, -9.0]
    machine = replace(numbers.machine, arm=replace(numbers.machine.arm, x0=s[layout.x0]))
    start = State(s[layout.alpha], s[layout.alpha_d], s[layout.theta], s[layout.theta_d])
    h = 2e-3
    time = np.arange(26, dtype=np.float64) * np.float64(h)
    forces = 30.0 + 15.0 * np.sin(40 * time[:, None] + np.arange(4.0))
    exact = simulate(machine, start, time, forces, max_step=2e-4)
    for row in range(25):
        change = observer.prediction.step(s, acceleration, forces[row], h, time[row] + h / 2).change
        s = s + change
        for speeds in (layout.alpha_d, layout.theta_d):
            acceleration[speeds] = change[speeds] / h
    np.testing.assert_allclose(s[layout.alpha], exact.alpha[-1], atol=np.radians(0.02))
    np.testing.assert_allclose(s[layout.theta], exact.theta[-1], atol=0.02)


def test_a_formula_that_cannot_be_traced_is_named() -> None:
    with pytest.raises(Untraceable, match=r"sort"):
        np.sort(symbols([variable("x")]))


def test_numbers_are_computed_and_zeros_vanish() -> None:
    x = variable("x")
    assert (as_expression(2.0) * 3.0).value == 6.0
    assert (x * 0.0).value == 0.0
    assert x + 0.0 is x
    assert apply("sin", as_expression(1.0)).value == math.sin(1.0)
