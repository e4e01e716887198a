"""xneck design by command: a table that controllers and our own reader take, and what is said of it."""

import json
from pathlib import Path

import numpy as np
import pytest

from identification.model_file import model_of, write_model
from mechanism.description import read_neck
from synchronisation.csv_table import read_table
from synchronisation.encoder_log import read_log
from tests.command import run
from tests.paths import NECK_FILE
from xneck_foundation.parameter import Parameter

FILE = NECK_FILE
SHORT = ("--seconds", "8", "--tries", "6")


def test_the_table_is_a_motion_within_the_limits(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "motion.csv"
    words = (
        "--peak-deg",
        "20",
        "--max-speed",
        "150",
        "--tension",
        "25",
        "100",
        "--for",
        "k",
        "--for",
        "k2",
    )
    done = run(capfd, "design", FILE, "--out", out, *SHORT, *words, "--json", "-")
    assert done.status == 0, done.err
    assert out.read_text().splitlines()[0] == (
        "time,alpha1,alpha2,alpha3,theta1,theta2,theta3,theta4,f1,f2,f3,f4,tension1,tension2,tension3,tension4"
    )
    table = read_table(out, ["alpha1", "alpha2", "alpha3"])
    np.testing.assert_allclose(np.diff(table.time), 0.002, atol=1e-9)
    assert table.time[-1] == pytest.approx(8.0)
    log = read_log(out, read_neck(FILE))
    assert np.degrees(np.abs(table.matrix("alpha")).max()) <= 20
    assert np.abs(np.diff(log.matrix("theta"), axis=0) / 0.002).max() <= 150
    found = json.loads(done.out)
    asked = {(p["name"], p["index"]) for p in found["parameters"] if p["for"]}
    assert asked == {(name, j) for name in ("k", "k2") for j in (1, 2, 3, 4)}
    assert all(p["sigma"] > 0 for p in found["parameters"])
    assert found["reached"]["tension_min_N"] > 25
    np.testing.assert_allclose(found["start"]["theta_rad"], log.matrix("theta")[0])


def test_effects_of_all_kinds_are_told_from_each_other(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A description's number, a law, and one that they are told from as well."""
    words = ("--for", "base_tilt", "--for", "actuator_gain", "--beside", "tip_payload", "--json", "-")
    done = run(capfd, "design", FILE, "--out", tmp_path / "motion.csv", *SHORT, *words)
    assert done.status == 0, done.err
    found = json.loads(done.out)
    assert [(a["effect"], a["beside"]) for a in found["effects"]] == [
        ("base_tilt", None),
        ("base_tilt", "actuator_gain"),
        ("base_tilt", "tip_payload"),
        ("actuator_gain", None),
        ("actuator_gain", "base_tilt"),
        ("actuator_gain", "tip_payload"),
    ]
    assert all(a["tells"] == (a["over_needed"] > 1) for a in found["effects"])
    assert not any(p["for"] for p in found["parameters"])


def test_a_stiffer_model_is_wound_less(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Ten times as stiff as it is taken for without a model, at the same tensions: motors stand nearer to slack."""
    stiff = [Parameter(name="k", index=j, value=8.3e4, unit="N/m", sigma=1.0, identified=True) for j in (1, 2, 3, 4)]
    write_model(model_of(stiff, ("linear_cable",), {}), tmp_path / "model.yaml")
    start = {}
    for name, words in (("soft", ()), ("stiff", ("--model", tmp_path / "model.yaml"))):
        done = run(
            capfd, "design", FILE, "--out", tmp_path / f"{name}.csv", *SHORT, "--for", "k", *words, "--json", "-"
        )
        assert done.status == 0, done.err
        start[name] = json.loads(done.out)["start"]
    x0 = np.array([cable.x0 for cable in read_neck(FILE).cables])
    wound = {name: 0.01 / 25 * np.array(s["theta_rad"]) + x0 for name, s in start.items()}
    pull = {name: np.array(s["tension_N"]) for name, s in start.items()}
    np.testing.assert_allclose(wound["soft"], pull["soft"] / 8.3e3)
    np.testing.assert_allclose(wound["stiff"], pull["stiff"] / 8.3e4)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--tension", "90", "30"), "leaves no range"),
        (("--for", "rust"), "unknown effect or parameter 'rust'"),
        (("--for", "base_tilts"), "did you mean base_tilt?"),
        (("--for", "base_tilt", "--beside", "k"), "k is no effect"),
        (("--tension", "60", "61"), "widen --tension"),
    ],
)
def test_refusals_are_one_line_and_leave_nothing(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], words: tuple[str, ...], said: str
) -> None:
    done = run(capfd, "design", FILE, "--out", tmp_path / "motion.csv", *SHORT, *words)
    assert done.status == 1
    assert done.err.count("\n") == 1
    assert said in done.err
    assert not list(tmp_path.iterdir())
