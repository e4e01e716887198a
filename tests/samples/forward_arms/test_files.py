"""Folders of arms are what xneck reads, and hold their truth."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mechanism.description import read_neck
from samples.forward_arms.arms import Arm, make_arms
from samples.forward_arms.files import write_arm
from samples.forward_arms.laws import Payload
from samples.forward_arms.plant import ROW
from synchronisation.angles import read_angles
from synchronisation.encoder_log import read_log
from tests.samples.forward_arms.plants import SHORT


def test_files_are_what_xneck_reads(arms: list[Arm], tmp_path: Path) -> None:
    write_arm(arms[0], tmp_path, replace(SHORT, sigma_columns=True))
    folder, recording = tmp_path / "rec01", arms[0].recordings[0]
    described = read_neck(folder / "neck.yaml")
    log = read_log(folder / "log.csv", described)
    np.testing.assert_allclose(log.matrix("theta"), recording.theta, atol=1e-8)
    np.testing.assert_allclose(log.matrix("f"), recording.f, atol=1e-8)
    angles = read_angles(folder / "alpha.csv", 3)
    np.testing.assert_allclose(angles.alpha, recording.film.seen, atol=1e-8)
    np.testing.assert_allclose(angles.sigma, recording.film.noise, atol=1e-8)
    truth = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    assert truth["recordings"]["rec01"]["offset"] == recording.film.offset
    assert truth["true"]["stiffness"] == list(arms[0].plant.stiffness)
    with np.load(tmp_path / "truth_rec01.npz") as fine:
        assert fine["alpha_ddot"].dtype == np.float64
        np.testing.assert_array_equal(fine["time"][:: arms[0].recordings[0].truth.per_row], recording.time)
        np.testing.assert_array_equal(fine["frame_alpha_mean"], recording.film.mean)


def test_effects_of_a_seed_are_in_its_arm_and_its_truth(tmp_path: Path) -> None:
    settings = replace(
        SHORT, mechanisms=1, seconds=0.2, step=ROW, laws=lambda seed: [Payload(0.05)] if seed == 2 else []
    )
    plain, hiding = make_arms([1, 2], settings)
    assert plain.laws == ()
    assert hiding.plant.bar_mass[0] == pytest.approx(hiding.drawing.bar_mass[0] + 0.05)
    write_arm(hiding, tmp_path, settings)
    truth = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    assert truth["hidden"] == [{"law": "Payload", "mass": 0.05, "at": 0.0}]
    described = read_neck(tmp_path / "rec01" / "neck.yaml")
    assert described.mechanisms[0].top.mass == pytest.approx(hiding.drawing.bar_mass[0])
