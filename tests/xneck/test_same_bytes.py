"""The same input gives the same bytes: whatever the threads, processes, hash seed, time zone and hour."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from identification.dataset.dataset_file import export_series
from identification.dataset.series import Series
from samples.generator.hidden.experiment import hide
from tests.paths import ROOT, SAMPLES

XNECK = [sys.executable, "-m", "xneck"]
WAYS = (
    {"OPENBLAS_NUM_THREADS": "1", "PYTHONHASHSEED": "0", "TZ": "UTC"},
    {"OPENBLAS_NUM_THREADS": "2", "PYTHONHASHSEED": "1", "TZ": "Asia/Tokyo", "LC_ALL": "C"},
    {"OPENBLAS_NUM_THREADS": "4", "PYTHONHASHSEED": "2", "TZ": "America/Lima", "LC_ALL": "C.UTF-8"},
)


def xneck(settings: dict[str, str], folder: Path, *words: str | Path) -> None:
    env = os.environ | settings | {"OMP_NUM_THREADS": settings["OPENBLAS_NUM_THREADS"], "PYTHONPATH": str(ROOT)}
    done = subprocess.run([*XNECK, *map(str, words), "--quiet"], cwd=folder, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def digests(folder: Path) -> dict[str, str]:
    """Of all files below a folder; how long a recording took is left out, and the mark, which follows from all of a file."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            content = path.read_bytes()
            if path.suffix == ".json":
                content = json.dumps(without_seconds(json.loads(content))).encode()
            elif path.name == "summary.html":
                continue  # its table has the seconds in it
            found[str(path.relative_to(folder))] = hashlib.sha256(content).hexdigest()
    return found


def without_seconds(value: object) -> object:
    if isinstance(value, dict):
        return {key: without_seconds(one) for key, one in value.items() if key not in ("seconds", "written_by")}
    return [without_seconds(one) for one in value] if isinstance(value, list) else value


@pytest.mark.parametrize("suffix", ["csv", "npz", "mat"])
def test_an_export_does_not_hold_the_hour(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    series = Series(np.arange(5.0), {"alpha1": np.ones(5)})
    written = []
    for hour in ("Mon Jan  1 00:00:00 2001", "Tue Feb  2 00:00:00 2022"):
        monkeypatch.setattr("time.asctime", lambda *_, hour=hour: hour)
        export_series(series, tmp_path / f"x.{suffix}")
        written.append((tmp_path / f"x.{suffix}").read_bytes())
    assert written[0] == written[1]
    assert b"Jan" not in written[0]


@pytest.mark.slow
def test_a_calibration_has_the_same_bytes(tmp_path: Path) -> None:
    """Three times, as OpenCV's threads end in another order every time."""
    board = SAMPLES / "recording/board"
    for k, settings in enumerate(WAYS):
        out = tmp_path / str(k)
        out.mkdir()
        words = ["calibrate", board, "--board", SAMPLES / "recording/board.yaml", "--out", "camera.yaml"]
        xneck(settings, out, *words, "--json", "result.json")
    assert digests(tmp_path / "0") == digests(tmp_path / "1") == digests(tmp_path / "2")


@pytest.mark.slow
def test_all_stages_have_the_same_bytes(tmp_path: Path) -> None:
    """Two recordings by one process or two, data sets, models, pages and a diagnosis."""
    hide((), 1, tmp_path, seconds=(9.0, 9.0))
    for k, settings in enumerate(WAYS[:2]):
        out = tmp_path / f"out{k}"
        xneck(settings, tmp_path, "run", "fitted", "held_out", "--out", out, "--jobs", str(1 + k % 2))
        words = [f"{out.name}/fitted/dataset.mcap", "--held-out", f"{out.name}/held_out/dataset.mcap"]
        xneck(settings, tmp_path, "diagnose", *words, "--out", f"{out.name}/diagnosis")
        xneck(settings, tmp_path, "identify", words[0], "--out", out / "m.yaml", "--export", "mat")
    one, other = (digests(tmp_path / f"out{k}") for k in range(2))
    assert len(one) > 15
    assert one == other
    shutil.rmtree(tmp_path)
