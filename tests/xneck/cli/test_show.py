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
