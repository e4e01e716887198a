"""From angles and a log to the verdict where neither OpenCV nor PyAV can be imported: only `vision` and `calibration` need them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from samples.generator.hidden.experiment import hide
from tests.paths import ROOT

BLOCKED = '''
import sys

class NoCamera:
    """Refuses the libraries that read pictures and videos."""

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("cv2", "av"):
            raise ImportError(f"{name} is not here")
        return None

sys.meta_path.insert(0, NoCamera())
'''
COMMANDS = """
import shlex
from xneck.cli import main

for command in (
    "sync fitted/angles.csv fitted/log.csv --neck fitted/neck.yaml --out fitted.mcap",
    "sync held_out/angles.csv held_out/log.csv --neck held_out/neck.yaml --out held_out.mcap",
    "check fitted.mcap",
    "identify fitted.mcap --out model.yaml",
    "simulate fitted.mcap --model model.yaml --out simulated.mcap",
    "diagnose fitted.mcap --held-out held_out.mcap --out diagnosis",
):
    sys.argv = ["xneck", *shlex.split(command), "--quiet"]
    try:
        main()
    except SystemExit as end:
        assert not end.code, command
"""
RUN = """
import xneck
from xneck.cli import main

assert len(xneck.synchronise("fitted").state) > 1000
sys.argv = "xneck run fitted --out results --quiet".split()
main()
"""
NOT_IMPORTED = """
assert not {"cv2", "av", "vision", "calibration"} & set(sys.modules)
"""


def run(folder: Path, code: str) -> str:
    """Standard output of an interpreter without a camera's libraries, in `folder`."""
    done = subprocess.run(
        [sys.executable, "-c", BLOCKED + code],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folders `fitted` and `held_out`, with angles.csv, log.csv and neck.yaml."""
    folder = tmp_path_factory.mktemp("recordings")
    hide(["tip_payload"], 7011, folder, seconds=(16.0, 10.0))
    return folder


def test_commands_go_from_csv_files_to_the_verdict(recordings: Path) -> None:
    run(recordings, COMMANDS + NOT_IMPORTED)
    record = json.loads((recordings / "diagnosis/diagnosis.json").read_text(encoding="utf-8"))
    assert (record["verdict"], [cause["effect"] for cause in record["causes"]]) == ("cause", ["tip_payload"])


def test_a_folder_is_synchronised_and_xneck_run_makes_the_report(recordings: Path) -> None:
    run(recordings, RUN)
    assert (recordings / "results/fitted/report.html").is_file()


@pytest.mark.parametrize("library", ["cv2", "av", "vision.extract", "calibration.estimation"])
def test_the_block_holds(library: str, tmp_path: Path) -> None:
    """A negative control: neither the libraries nor what needs them can be imported."""
    with pytest.raises(AssertionError, match="is not here"):
        run(tmp_path, f"import {library}")
