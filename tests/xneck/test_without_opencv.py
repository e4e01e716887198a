"""A recording with angles goes all the way where OpenCV and PyAV cannot be imported."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from samples.generator.hidden.experiment import hide
from tests.paths import ROOT

BLOCKED = """
import sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("cv2", "av"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Blocker())
"""
COMMAND = BLOCKED + "from xneck.cli import main; main()"
COMMANDS = (
    BLOCKED
    + """
from xneck.cli import main
for step in sys.argv[1:]:
    sys.argv = ["xneck", *step.split()]
    try:
        main()
    except SystemExit as end:
        assert not end.code, step
"""
)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folders `fitted` and `held_out`, with angles.csv and log.csv."""
    folder = tmp_path_factory.mktemp("recordings")
    hide(["tip_payload"], 7011, folder, seconds=(16.0, 10.0))
    return folder


def python(code: str, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code, *words], capture_output=True, text=True, cwd=folder, env={"PYTHONPATH": str(ROOT)}
    )


def test_the_block_blocks(tmp_path: Path) -> None:
    for module in ("cv2", "av"):
        assert f"No module named '{module}'" in python(BLOCKED + f"import {module}", tmp_path).stderr


def test_xneck_run_makes_the_report(recordings: Path) -> None:
    done = python(COMMAND, recordings, "run", "fitted", "--out", "results")
    assert (done.returncode, done.stderr) == (0, "")
    assert (recordings / "results/fitted/report.html").is_file()


def test_from_angles_and_log_to_the_verdict_step_by_step(recordings: Path) -> None:
    steps = (
        "sync fitted/angles.csv fitted/log.csv --neck fitted/neck.yaml --out fitted.mcap",
        "sync held_out/angles.csv held_out/log.csv --neck held_out/neck.yaml --out held_out.mcap",
        "check fitted.mcap",
        "identify fitted.mcap --out model.yaml",
        "simulate fitted.mcap --model model.yaml --out simulated.mcap",
        "diagnose fitted.mcap --held-out held_out.mcap --out diagnosis",
    )
    done = python(COMMANDS, recordings, *steps)
    assert (done.returncode, done.stderr) == (0, "")
    record = json.loads((recordings / "diagnosis/diagnosis.json").read_text(encoding="utf-8"))
    assert (record["verdict"], [cause["effect"] for cause in record["causes"]]) == ("cause", ["tip_payload"])


def test_the_python_function_gives_the_data_set(recordings: Path) -> None:
    code = BLOCKED + "import xneck; print(len(xneck.synchronise('fitted').state) > 1000, 'cv2' in sys.modules)"
    done = python(code, recordings)
    assert done.stdout == "True False\n", done.stderr
