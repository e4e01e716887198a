"""What a batch calls its recordings, and how it may not be asked."""

from pathlib import Path

import pytest

from tests.command import run
from xneck.batch.run_batch import recordings_by_name
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


def test_wrong_usage(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(capfd, "run", tmp_path, "--jobs", "2", "--cluster", "tcp://x:1").status == 2
