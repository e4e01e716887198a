"""What cables carry of springs and gravity, by which an arm is strong or weak."""

import numpy as np
import pytest

from mechanism.arm import arm_of
from mechanism.description import Springs, read_neck
from mechanism.typical_load import typical_load
from tests.paths import NECK_FILE
from tests.similar_arms import similar_neck

NECK = read_neck(NECK_FILE)


@pytest.mark.parametrize(("length", "force"), [(1.0, 30.0), (0.5, 0.01), (2.5, 2.5)])
def test_it_goes_with_the_forces_and_not_with_the_size(length: float, force: float) -> None:
    similar = typical_load(arm_of(similar_neck(NECK, length, force)))
    assert similar == pytest.approx(force * typical_load(arm_of(NECK)), rel=1e-9)


def test_it_is_a_part_of_what_a_spring_pulls_with() -> None:
    """Springs and cables run side by side, one of a pair of springs against the other."""
    arm = arm_of(NECK)
    extension = np.mean(arm.L) - np.mean(arm.spring_free_length)
    assert 0.1 < typical_load(arm) / (np.mean(arm.spring_stiffness) * extension) < 1.0


def test_an_arm_that_nothing_pulls_has_some_newtons() -> None:
    flat = NECK.model_copy(
        update={
            "gravity": (0.0, 0.0),
            "mechanisms": tuple(
                m.model_copy(update={"springs": m.springs.model_copy(update={"stiffness": 0.0, "right": None})})
                for m in NECK.mechanisms
            ),
        }
    )
    assert isinstance(flat.mechanisms[0].springs, Springs)
    assert typical_load(arm_of(flat)) == 10.0
