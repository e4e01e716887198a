"""A designed motion is what the arm does under its controller."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identification.dataset.dataset_file import export_series
from identification.design.fourier import random_shape, tone_frequencies
from identification.design.nominal_machine import nominal_machine
from identification.design.result import motion_series
from identification.design.trajectory import USUAL_LIMITS, Trajectory, trajectory
from mechanism.description import read_neck
from samples.forward_arms.arms import make_arms
from samples.forward_arms.given_motion import read_motion
from tests.paths import NECK_FILE
from tests.samples.forward_arms.plants import SHORT

SECONDS = 5.0


@pytest.fixture(scope="module")
def designed() -> Trajectory:
    shape = random_shape(tone_frequencies(4, SECONDS, (0.1, 2.0)), np.random.default_rng(1))
    limits = replace(USUAL_LIMITS, peak=np.radians(15.0), speed=100.0)
    return trajectory(nominal_machine(read_neck(NECK_FILE)), shape, limits, SECONDS, 500.0)


def test_the_arm_follows_the_table(designed: Trajectory, tmp_path: Path) -> None:
    """Not exactly: the controller has its own arm in mind, its friction is fed forward in part, and cables stretch."""
    export_series(motion_series(designed), tmp_path / "motion.csv")
    motion = read_motion(tmp_path / "motion.csv")
    assert motion.seconds == pytest.approx(SECONDS)
    np.testing.assert_allclose(motion.tension, designed.tension, atol=1e-6)
    settings = replace(SHORT, seconds=SECONDS, first_recording=1)
    (arm,) = make_arms([11], settings, motions=[motion])
    truth = arm.recordings[0].truth.within_log()
    played, wanted = truth.alpha[:: truth.per_row], designed.alpha[: len(truth.time[:: truth.per_row])]
    assert np.sqrt(np.mean((played - wanted) ** 2)) < 0.2 * np.sqrt(np.mean(wanted**2))
    tension = truth.tension[:: truth.per_row]
    for j in range(arm.plant.M):
        assert np.corrcoef(tension[:, j], designed.tension[: len(tension), j])[0, 1] > 0.8


def test_what_rests_before_and_after_is_the_first_and_the_last_row(designed: Trajectory, tmp_path: Path) -> None:
    export_series(motion_series(designed), tmp_path / "motion.csv")
    asked = read_motion(tmp_path / "motion.csv").asked(np.array([-1.0, SECONDS + 1.0]))
    np.testing.assert_allclose(asked.alpha, 0.0, atol=1e-9)
    np.testing.assert_allclose(asked.about[:, 0], designed.tension[0], atol=1e-6)


def test_a_table_without_tensions_and_a_motion_that_is_too_long_are_refused(
    designed: Trajectory, tmp_path: Path
) -> None:
    (tmp_path / "motion.csv").write_text("time,alpha1\n0,0\n1,0\n")
    with pytest.raises(ValueError, match=r"motion.csv: no columns tension1, tension2"):
        read_motion(tmp_path / "motion.csv")
    export_series(motion_series(designed), tmp_path / "long.csv")
    with pytest.raises(ValueError, match=r"5 s does not fit into recordings of 3\.6 s"):
        next(make_arms([11], SHORT, motions=[read_motion(tmp_path / "long.csv")]))
