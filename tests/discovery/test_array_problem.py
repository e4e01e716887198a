"""What a residual that is given as an array may follow."""

import numpy as np
import pytest

from discovery.array_problem import UNITS, ArrayProblem


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("motor_angle", "rad"),
        ("drum_angle", "rad"),
        ("joint_angle", "rad"),
        ("motor_speed", "rad/s"),
        ("joint_speed", "rad/s"),
        ("force", "N"),
        ("tension", "N"),
        ("temperature", "1"),
    ],
)
def test_a_variable_has_the_unit_of_its_name(name: str, unit: str) -> None:
    """Angles are in radians, their rates in radians a second, forces in newtons; of other names nothing is known."""
    rng = np.random.default_rng(0)
    block = np.arange(400) * 10 // 400
    values = {name: rng.normal(size=400), "time": 0.01 * np.arange(400)}
    problem = ArrayProblem(rng.normal(size=400), values, block, (), 1.0)
    units = {c.follows[0]: c.unit for c in problem.candidates if len(c.follows) == 1}
    assert units == {name: unit, "time": "s"}
    assert UNITS.get(name, "1") == unit
