"""From somebody's own log to a neck.yaml that reads it, by the commands."""

import json
from pathlib import Path

import numpy as np
import pytest

from mechanism.description import read_neck
from synchronisation.encoder_log import read_log
from tests.command import run
from tests.paths import NECK_FILE, SAMPLES
from tests.synchronisation.test_any_log import DEGREES, GEAR, columns_of, table, truth


@pytest.fixture
def log(tmp_path: Path) -> Path:
    how = ("winch{} pos [deg]", "winch{} torque cmd [Nm]", DEGREES, 1 / GEAR, "t_ms", 1e3)
    return table(tmp_path / "controller.csv", columns_of(truth(), *how), ";", ",")


def test_a_description_that_is_there_gets_the_mapping(
    log: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    before, out = log.read_bytes(), tmp_path / "mapped.yaml"
    ran = run(capfd, "logs", log, "--neck", NECK_FILE, "--out", out, "--json", tmp_path / "logs.json")
    assert (ran.status, ran.err) == (0, "")
    for words in (
        "500 rows a second",
        "winch1 pos [deg]",
        "angle of a motor in deg",
        "force in N m, as commanded",
        "parted by",
    ):
        assert words in ran.out
    found = read_log(log, read_neck(out))
    np.testing.assert_allclose(found.matrix("theta"), truth().matrix("theta"), rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(found.matrix("f"), truth().matrix("f"), rtol=1e-5, atol=1e-4)
    record = json.loads((tmp_path / "logs.json").read_text())
    assert record["mapping"]["log"] == {"time_column": "t_ms", "time_scale": 0.001, "separator": ";", "decimal": ","}
    assert log.read_bytes() == before


def test_a_new_description_may_begin_with_the_log(log: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "neck.yaml"
    ran = run(capfd, "init", "--mechanisms", "3", "--log", log, "--out", out)
    assert (ran.status, ran.err) == (0, "")
    neck = read_neck(out)
    assert neck.M == 4
    found = read_log(log, neck)
    np.testing.assert_allclose(found.matrix("theta"), truth().matrix("theta"), rtol=1e-5, atol=1e-4)
    scale = neck.motors[0].R / neck.motors[0].rd / GEAR
    np.testing.assert_allclose(found.matrix("f"), scale * truth().matrix("f"), rtol=1e-4)


def test_without_out_nothing_is_written(log: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = run(capfd, "logs", log)
    assert ran.status == 0
    assert 'theta_column: "winch2 pos [deg]"' in ran.out
    assert list(tmp_path.iterdir()) == [log]


def test_an_mcap_says_its_topics_and_joints(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "mapped.yaml"
    source = SAMPLES / "held_out"
    ran = run(capfd, "logs", source / "log.mcap", "--neck", source / "neck.yaml", "--out", out)
    assert (ran.status, ran.err) == (0, "")
    assert "topic /joint_states" in ran.out
    plain, mapped = (read_log(source / "log.mcap", read_neck(neck)) for neck in (source / "neck.yaml", out))
    np.testing.assert_array_equal(plain.matrix("theta"), mapped.matrix("theta"))


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("log.xlsx", b"PK\x03\x04", "is no CSV but a ZIP archive, as .xlsx and .npz are; export it as CSV"),
        ("log.mat", b"\x01\x02\xff", "cannot be read as CSV (not UTF-8 text); export it as CSV"),
        (
            "log.lvm",
            b"LabVIEW Measurement\t\n",
            "settings stand above its table; leave out all above the row of X_Value",
        ),
        ("video.mp4", b"\0\0\0\x20ftypisom", "is no CSV but a video; give a table or an MCAP here"),
        ("log.csv", b"", "is empty"),
        ("log.mcap", b"", "is empty"),
    ],
)
def test_what_is_no_log_is_refused_alike_by_logs_and_sync(
    name: str, content: bytes, says: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    log, angles = tmp_path / name, tmp_path / "angles.csv"
    log.write_bytes(content)
    angles.write_text("time,alpha1,alpha2,alpha3\n0,0,0,0\n0.03,0,0,0\n")
    neck, out = SAMPLES / "held_out/neck.yaml", tmp_path / "dataset.mcap"
    for words in (["logs", log], ["sync", angles, log, "--neck", neck, "--out", out]):
        ran = run(capfd, *words)
        assert (ran.status, ran.out) == (1, "")
        assert says in ran.err


def test_two_columns_of_one_name_are_refused(log: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The one would hide the other, and a motor would be missed."""
    header, *rows = log.read_text().splitlines()
    twice = tmp_path / "twice.csv"
    twice.write_text("\n".join([header.replace("winch2 pos", "winch1 pos"), *rows, ""]))
    refused = run(capfd, "logs", twice, "--neck", NECK_FILE)
    assert refused.status == 1
    assert refused.err.strip() == f"xneck: {twice}: has the column 'winch1 pos [deg]' 2 times; name each column once"


def test_text_of_any_suffix_is_read(log: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.dat").write_bytes(log.read_bytes())
    assert run(capfd, "logs", tmp_path / "log.dat").status == 0


def test_out_alone_is_wrong_usage(log: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = run(capfd, "logs", log, "--out", tmp_path / "neck.yaml")
    assert ran.status == 2
    assert "--neck" in ran.err
