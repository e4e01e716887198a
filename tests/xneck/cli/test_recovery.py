"""What a damaged file lost reaches the person and the program that called a command, and the result."""

import json
from pathlib import Path

import numpy as np
import pytest

from identification.dataset.dataset_file import read_dataset
from synchronisation.angles import read_angles, write_angles
from tests.command import run
from tests.paths import SAMPLES
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import Recovered

H = SAMPLES / "held_out"


def test_a_log_that_is_cut_off_is_used_and_said_to_be(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The log of 25 s without its last tenth, which the video does not show anyway: the same clock; then its data set, halved."""
    whole = (H / "log.mcap").read_bytes()
    log, out, result = tmp_path / "log.mcap", tmp_path / "d.mcap", tmp_path / "r.json"
    log.write_bytes(whole[: int(0.95 * len(whole))])
    words = ["sync", H / "angles.csv", log, "--neck", H / "neck.yaml", "--out", out, "--json", result, "--quiet"]
    status, printed, err = run(capfd, *words)
    assert (status, printed) == (0, "")
    assert err.startswith(f"xneck: warning: {log}: is cut off; /joint_states has ")
    assert err.count("\n") == 1
    said = json.loads(result.read_text())["recovered"]
    assert [f"xneck: warning: {line}\n" for line in said] == [err]
    assert read_dataset(out).provenance["recovered"] == said
    whole = out.read_bytes()
    out.write_bytes(whole[: len(whole) * 7 // 10])
    status, printed, err = run(capfd, "check", out, "--json", "-")
    assert status == 0
    assert "/state has " in err
    assert json.loads(printed)["recovered"] == [err.removeprefix("xneck: warning: ").rstrip()]


def test_whole_files_lose_nothing(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = run(
        capfd,
        *("sync", H / "angles.csv", H / "log.mcap", "--neck", H / "neck.yaml"),
        *("--out", tmp_path / "d.mcap", "--json", "-"),
    )
    assert (ran.status, ran.err) == (0, "")
    assert json.loads(ran.out)["recovered"] == []


def test_angles_that_are_cut_off_are_a_shorter_video(tmp_path: Path) -> None:
    path = tmp_path / "angles.mcap"
    angles = read_angles(H / "angles.csv", 3)
    repeated = 20  # a chunk holds more frames than the sample has
    time = (angles.time[:, None] + 30.0 * np.arange(repeated)).T.ravel()
    longer = type(angles)(time, *(np.tile(v, (repeated, 1)) for v in (angles.alpha, angles.sigma)), notes={"n": 1})
    write_angles(longer, path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 8 // 10])
    with pytest.warns(Recovered, match=rf"/angles has \d+ of {len(time)} rows"):
        back = read_angles(path, 3)
    assert back.notes == {"n": 1}
    np.testing.assert_array_equal(back.alpha, longer.alpha[: len(back.time)])
    path.write_bytes(whole[:100])
    with pytest.raises(Refused, match="not one row"):
        read_angles(path, 3)
