"""Angles that read something while the arm stands straight: neck.yaml says how much, and every file's way in takes it off."""

from pathlib import Path

import numpy as np
import pytest

from identification.dataset.dataset import DataSet
from identification.dataset.dataset_file import export_series
from identification.dataset.series import Series, numbered_columns
from mechanism.description import read_neck
from synchronisation.angles import Angles, read_angles
from synchronisation.frames_on_log import read_frames_on_log
from synchronisation.long.synchronise_parts import synchronise_parts
from synchronisation.synchronise import synchronise
from tests.identification.test_estimates import recording
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

ZERO = (0.02, -0.013, 0.05)
NECK = read_neck(NECK_FILE)
ZEROED = NECK.with_({"alpha_zero": ZERO})


@pytest.fixture(scope="module")
def right() -> DataSet:
    """Of angles that are zero where the arm stands straight."""
    return recording(2001)


def test_the_state_is_that_of_angles_with_the_right_zero(right: DataSet) -> None:
    seen = right.angles
    read = Angles(seen.time, seen.matrix("alpha") + ZERO, seen.matrix("sigma"))
    again = synchronise(ZEROED, "", read, right.log, {})
    np.testing.assert_allclose(again.state.matrix("alpha"), right.state.matrix("alpha"), atol=1e-9)
    assert again.neck.alpha_zero == ZERO
    off = synchronise(NECK, "", read, right.log, {})  # what the key is worth
    assert abs(off.state.matrix("alpha") - right.state.matrix("alpha")).max() > 0.01


def test_parts_of_a_long_recording_have_it_too(right: DataSet, tmp_path: Path) -> None:
    angles = Series(
        right.angles.time,
        numbered_columns("alpha", right.angles.matrix("alpha") + ZERO)
        | numbered_columns("sigma", right.angles.matrix("sigma")),
    )
    export_series(angles, tmp_path / "angles.csv")
    parts = synchronise_parts(ZEROED, "", read_angles(tmp_path / "angles.csv", 3), right.log, {}, tmp_path)
    np.testing.assert_allclose(parts.angles.matrix("alpha"), right.angles.matrix("alpha"), atol=1e-9)


def test_frames_that_an_observer_gets_now_and_then_have_it_too(right: DataSet, tmp_path: Path) -> None:
    time = right.log.time[100:-100:500]
    read = np.full((len(time), 3), 0.1)
    export_series(Series(time, numbered_columns("alpha", read)), tmp_path / "seen.csv")
    frames = read_frames_on_log(tmp_path / "seen.csv", ZEROED, right.log)
    np.testing.assert_allclose(frames.alpha, read - ZERO, atol=1e-12)


@pytest.mark.parametrize(
    ("zero", "says"),
    [((0.01, 0.02), "alpha_zero: 2 angles for 3 mechanisms, and each has one"), ((0.0, 1.2, 0.0), r"alpha_zero.*1\.2")],
)
def test_one_for_each_joint_and_no_degrees(zero: tuple[float, ...], says: str) -> None:
    with pytest.raises(Refused, match=says):
        NECK.with_({"alpha_zero": zero})
