"""Laws of the actuators taken together: what the log says where a force acts, and what acts where the log says it."""

import numpy as np
import pytest

from mechanism.arm import arm_of
from mechanism.description import read_neck
from mechanism.machine import Machine
from tests.paths import NECK_FILE

ARM = arm_of(read_neck(NECK_FILE))
STEP = 0.002
VALUES = {
    "g": np.array([0.25, -0.2, 0.1, 0.0]),
    "fo": np.array([10.0, -4.0, 0.0, 3.0]),
    "taul": np.array([0.004]),
}
GAIN, OFFSET, LAG = "actuator_gain", "actuator_offset", "actuator_lag"


@pytest.mark.parametrize(
    ("names", "acts"),
    [
        ((GAIN, OFFSET), 110 / 1.25 - 10),
        ((OFFSET, GAIN), (110 - 10) / 1.25),
    ],
)
def test_gain_and_offset_act_in_the_order_of_their_names(names: tuple[str, ...], acts: float) -> None:
    """Of 110 N that are logged 78 or 80 act on the first motor, and 110 N are commanded where these are wanted."""
    machine = Machine(ARM, names, VALUES)
    logged = np.full((5, 4), 110.0)
    acting = machine.acting_force(logged, STEP)
    np.testing.assert_allclose(acting[:, 0], acts, rtol=1e-12)
    np.testing.assert_allclose(machine.commanded_force(np.full((5, 4), acts), STEP)[:, 0], 110.0, rtol=1e-12)


@pytest.mark.parametrize("names", [(GAIN, OFFSET), (OFFSET, GAIN), (GAIN, OFFSET, LAG), (LAG, OFFSET, GAIN)])
def test_what_is_commanded_for_a_force_makes_it_act(names: tuple[str, ...]) -> None:
    machine = Machine(ARM, names, VALUES)
    wanted = np.random.default_rng(0).normal(50, 9, (20, 4))
    commanded = machine.commanded_force(wanted, STEP)
    assert np.abs(commanded - wanted).max() > 1
    np.testing.assert_allclose(machine.acting_force(commanded, STEP), wanted, rtol=1e-10)
    np.testing.assert_allclose(machine.commanded_force(machine.acting_force(wanted, STEP), STEP), wanted, rtol=1e-10)
