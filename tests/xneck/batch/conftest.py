"""A batch of four recordings, two of them broken, whose worker is killed once."""

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from samples.generator.hidden.experiment import hide
from tests.command import Ran
from tests.xneck.batch.recordings import NASTY, XNECK, cut_short, worker_of


@pytest.fixture(scope="session")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """One with a name that tries to be markup, one whose log lacks a column, one cut off, one without a recording.yaml."""
    home = tmp_path_factory.mktemp("recordings")
    hide((), 1, home, seconds=(9.0, 9.0))
    (home / "truth.json").unlink()
    (home / "fitted").rename(home / NASTY)
    (home / "held_out").rename(home / "broken")
    log = home / "broken/log.csv"
    log.write_text(log.read_text().replace("f3", "g3", 1))
    cut_short(home / "cut")
    (home / "empty").mkdir()
    return sorted(home.iterdir())


@pytest.fixture(scope="session")
def batch(recordings: list[Path], tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Ran]:
    """All by one worker, which is killed once in the middle of the first."""
    out = tmp_path_factory.mktemp("results")
    (out / NASTY).mkdir()
    (out / NASTY / ".report.xneck-0a1b2c3d.html").write_text("what an earlier kill left")
    (out / NASTY / "notes.txt").write_text("a person's own")
    words = [*XNECK, "run", *map(str, recordings), "--out", str(out), "--jobs", "1"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as command:
        while not (out / NASTY / "dataset.mcap").exists() and command.poll() is None:
            time.sleep(0.02)
        victim = worker_of(command.pid)
        assert victim is not None
        os.kill(victim, signal.SIGKILL)
        printed, said = command.communicate()
    return out, Ran(command.returncode, printed, said)
