"""Which recordings are of one arm."""

from types import SimpleNamespace
from typing import Any

import pytest

from identification.estimates import common_arm
from mechanism.arm import arm_of
from mechanism.description import Neck, read_neck
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

NECK = read_neck(NECK_FILE)


def recorded_with(neck: Neck) -> Any:
    return SimpleNamespace(neck=neck, arm=arm_of(neck))


def with_cables(**change: float) -> Neck:
    """The same with something else of its first cable."""
    first, *others = NECK.cables
    return NECK.model_copy(update={"cables": (first.model_copy(update=change), *others)})


@pytest.mark.parametrize("other", [with_cables(x0=0.009), NECK.model_copy(update={"markers": None})])
def test_one_arm_may_be_wound_and_marked_otherwise(other: Neck) -> None:
    """Where the motors started is the recording's own, and so is what was filmed. The arm is that of the first."""
    first = recorded_with(NECK)
    assert common_arm([first, recorded_with(other)]) is first.arm


@pytest.mark.parametrize("other", [with_cables(length=0.91), NECK.model_copy(update={"gravity": (0.0, -1.62)})])
def test_another_cable_or_another_planet_is_another_arm(other: Neck) -> None:
    with pytest.raises(Refused, match="different arms"):
        common_arm([recorded_with(NECK), recorded_with(other)])
