"""What a batch calls its recordings, and how it may not be asked."""

from pathlib import Path

import pytest

from tests.command import run
from xneck.batch.run_batch import named_twice, recordings_by_name
from xneck_foundation.errors import Refused


def test_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("monday/1", "tuesday/1", "tuesday/2", "results"):
        (tmp_path / name).mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    one, two, out = Path("tuesday/1"), Path("tuesday/2"), Path("results")
    assert recordings_by_name([one, two, tmp_path / "tuesday/2", out], out) == {"1": one, "2": two}
    with pytest.raises(Refused, match="two recordings are called 1: monday/1 and tuesday/1"):
        recordings_by_name([Path("monday/1"), one], out)
    with pytest.raises(Refused, match="no recording is given"):
        recordings_by_name([out], out)


def test_links_to_a_recording_are_told(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    monday, link, out = tmp_path / "monday", tmp_path / "again", tmp_path / "results"
    monday.mkdir()
    link.symlink_to(monday)
    named = recordings_by_name([monday, link, monday], out)
    assert (named, named_twice([monday, link, monday], named)) == ({"monday": monday}, {link: monday})
    ran = run(capfd, "run", monday, link, "--out", out)
    assert f"xneck: warning: {link} was left out: it is {monday} under another name\n" in ran.err


def test_wrong_usage(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(capfd, "run", tmp_path, "--jobs", "2", "--cluster", "tcp://x:1").status == 2
