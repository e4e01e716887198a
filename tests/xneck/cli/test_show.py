"""The arm as a drawing: a file of the kind that is asked for, the same each time, and never in somebody else's place."""

import json
from pathlib import Path

import numpy as np
import pytest

from mechanism.arm import arm_of
from mechanism.cable_lengths import lengths
from mechanism.description import read_neck
from tests.command import run
from tests.paths import NECK_FILE


@pytest.mark.parametrize(("suffix", "begins"), [("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_it_is_drawn(suffix: str, begins: bytes, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / f"neck.{suffix}"
    ran = run(capfd, "show", NECK_FILE, "--out", out, "--alpha", "-20,15,30", "--json", tmp_path / "show.json")
    assert (ran.status, ran.err) == (0, "")
    first = out.read_bytes()
    assert first.startswith(begins)
    record = json.loads((tmp_path / "show.json").read_text())
    alpha = np.radians([-20.0, 15.0, 30.0])
    np.testing.assert_allclose(record["cable_length_m"], lengths(arm_of(read_neck(NECK_FILE)), alpha), rtol=1e-12)
    assert run(capfd, "show", NECK_FILE, "--out", out, "--alpha", "-20,15,30").status == 0
    assert out.read_bytes() == first
    out.write_bytes(b"mine")
    refused = run(capfd, "show", NECK_FILE, "--out", out)
    assert (refused.status, out.read_bytes()) == (1, b"mine")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--out", "a.svg", "--alpha", "1,2"], "2 angles for 3 joints"),
        (["--out", "a.svg", "--alpha", "one"], "'one' is no list of numbers; write numbers in deg"),
        (["--out", "a.svg", "--alpha", "190"], "190 deg is not within +-180 deg"),
        (["--out", "a.svg", "--alpha", "nan"], "nan deg is not within +-180 deg"),
        (["--out", "a.gif"], "unknown suffix"),
    ],
)
def test_what_cannot_be_drawn_is_refused(
    words: list[str], says: str, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    ran = run(capfd, "show", NECK_FILE, *words)
    assert (ran.status, ran.out) == (1, "")
    assert says in ran.err
    assert list(tmp_path.iterdir()) == []


MARKED = "markers:\n  dictionary: apriltag_36h11\n  size: 0.03\n  on_bars:\n"
BASE = "    - {id: 0, bar: 0}\n"


@pytest.mark.parametrize("command", ["show", "board"])
@pytest.mark.parametrize(
    ("markers", "status", "says"),
    [
        (
            MARKED + BASE + "    - {id: 9999, bar: 1}\n",
            1,
            "markers.on_bars[1].id is 9999, but apriltag_36h11 has the ids",
        ),
        (MARKED.replace("11", "12") + BASE, 1, "markers.dictionary: unknown dictionary 'apriltag_36h12'; did you mean"),
        (MARKED + BASE + "    - {id: 1, bar: 0}\n", 1, "markers.on_bars[1] is at the same place of bar 0 as [0]"),
        (MARKED + "    - {id: 1, bar: 3}\n", 0, "warning: no marker sits on the base (bar 0)"),
        (MARKED + BASE + "    - {id: 1, diagonal: A1}\n", 0, "warning: no marker tells joint 2, 3: put one on bar 3"),
        (MARKED + BASE + "    - {id: 1, bar: 3}\n", 0, "warning: bar 1, 2 has no marker: the joints on both sides"),
    ],
)
def test_markers_that_no_camera_can_use_are_told_before_they_are_printed(
    command: str, markers: str, status: int, says: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    neck = tmp_path / "neck.yaml"
    neck.write_text(NECK_FILE.read_text().partition("markers:")[0] + markers)
    ran = run(capfd, command, neck, "--out", tmp_path / "out.pdf", "--json", tmp_path / "record.json")
    assert ran.status == status
    assert says in ran.err
    if status == 0:
        lines = json.loads((tmp_path / "record.json").read_text())["warnings"]
        assert "".join(f"xneck: warning: {line}\n" for line in lines) == ran.err


def test_a_cable_shorter_than_its_way_is_told(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    neck = tmp_path / "neck.yaml"
    neck.write_text(NECK_FILE.read_text().replace("length: 0.9", "length: 0.02"))
    ran = run(capfd, "show", neck, "--out", tmp_path / "neck.svg", "--quiet")
    assert ran.status == 0
    assert "warning: cables[0].length is 0.02 m, but the cable runs 0.0946 m from the base up" in ran.err
