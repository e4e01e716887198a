"""A pose or a description that is refused names what and where, and each limit is where the arm has it."""

from dataclasses import replace

import numpy as np
import pytest

from mechanism.arm import arm_of, batch
from mechanism.description import markers_of, read_neck
from mechanism.geometry import check_angles
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

NECK = read_neck(NECK_FILE)
ARM = arm_of(NECK)


def said(alpha: list[float]) -> str:
    with pytest.raises(Refused) as refused:
        check_angles(ARM, np.array([[0.0, 0.1, 0.0], alpha]))
    return str(refused.value)


def test_the_worst_angle_is_named_in_degrees() -> None:
    line = said([np.radians(100.0), 0.0, np.radians(-190.0)])
    assert line.startswith("alpha: alpha3 = -190.0 deg is at or past the singular pose of 180 deg")
    assert "are the angles in radians?" in line
    assert "alpha2 = 180.0 deg is at or past" in said([0.0, np.pi, 0.0])
    line = said([0.0, np.nan, 0.0])
    assert line.startswith("alpha: has values that are not finite")
    assert "leave such samples out" in line


@pytest.mark.parametrize("way", [-1, 1])
def test_a_pulley_fits_until_the_shorter_side_is_its_radius(way: int) -> None:
    """Bent by 120 deg the shorter side is sqrt(L^2 - b^2/4) - b sqrt(3)/2: pulleys of that radius fit up to there."""
    L, b = float(ARM.L[0]), float(ARM.b[0])
    thick = replace(ARM, r=np.full(3, np.sqrt(L**2 - b**2 / 4) - b * np.sqrt(3) / 2))
    check_angles(thick, np.array([[0.1, way * np.radians(119.99), 0.2]]))
    shown = rf"at alpha2 = {way * 120.1:.1f} deg a pulley no longer fits between the bars"
    with pytest.raises(Refused, match=shown):
        check_angles(thick, np.array([[0.1, 0.2, 0.3], [0.1, way * np.radians(120.1), 0.2]]))


def test_an_arm_without_markers_is_refused_where_they_are_asked_for() -> None:
    with pytest.raises(Refused, match=r"^neck.yaml: has no `markers`.*say which markers sit on which bars"):
        markers_of(NECK.model_copy(update={"markers": None}), "neck.yaml")
    assert markers_of(NECK, "neck.yaml") is NECK.markers


def test_arms_of_one_kind_are_stacked_and_others_are_not() -> None:
    two = batch([ARM, replace(ARM, L=ARM.L * 1.1)])
    np.testing.assert_allclose(two.L, [ARM.L, ARM.L * 1.1])
    assert (two.routes, two.spring_slack) == (ARM.routes, ARM.spring_slack)
    with pytest.raises(ValueError, match="same routes"):
        batch([ARM, replace(ARM, routes=ARM.routes[::-1])])
