"""kill -9 in the middle of a command: no output is there in part, what it left is swept up, and the same command then succeeds."""

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from calibration.camera_file import read_camera
from identification.dataset.dataset_file import read_dataset
from identification.files import joint_state
from identification.model_file import read_model
from synchronisation.angles import read_angles
from tests.paths import ROOT
from tests.robustness.judge import MORE, TRIED
from tests.robustness.sources import R
from xneck_foundation.authorship import written_by_xneck
from xneck_foundation.whole_file import whole_file

Reads = Callable[[Path], Any]


def page(path: Path) -> None:
    assert "</html>" in path.read_text(encoding="utf-8")
    assert written_by_xneck(path)


def text(path: Path) -> None:
    assert path.read_text(encoding="utf-8").endswith("\n")


BY_NAME: dict[str, Reads] = {
    "d.mcap": read_dataset,
    "dataset.mcap": read_dataset,
    "s.mcap": joint_state.read,
    "simulated.mcap": joint_state.read,
    "angles.mcap": lambda path: read_angles(path, 3),
    "m.yaml": read_model,
    "model.yaml": read_model,
    "c.yaml": read_camera,
    "camera.yaml": read_camera,
}
BY_SUFFIX: dict[str, Reads] = {".html": page, ".json": text, ".yaml": text, ".md": text, ".csv": text}

COMMANDS: dict[str, list[str]] = {
    "sync": [
        "sync",
        "{r}/angles.csv",
        "{r}/log.csv",
        "--neck",
        "{r}/neck.yaml",
        "--out",
        "{o}/d.mcap",
        "--export",
        "csv",
    ],
    "identify": ["identify", "{r}/d.mcap", "--out", "{o}/m.yaml"],
    "simulate": ["simulate", "{r}/d.mcap", "--model", "{r}/m.yaml", "--out", "{o}/s.mcap"],
    "run": ["run", "{r}", "--out", "{o}"],
    "diagnose": ["diagnose", "{r}/d.mcap", "--out", "{o}/diagnosis"],
    "calibrate": [
        "calibrate",
        "{R}/board",
        "--board",
        "{R}/board.yaml",
        "--out",
        "{o}/c.yaml",
        "--report",
        "{o}/c.html",
    ],
    "design": ["design", "{r}/neck.yaml", "--out", "{o}/m.csv", "--seconds", "10", "--tries", "6"],
    "extract": [
        "extract",
        "{R}/video.mp4",
        "--camera",
        "{s}/camera.yaml",
        "--neck",
        "{R}/neck.yaml",
        "--out",
        "{o}/angles.mcap",
    ],
    "study": ["study", "--out", "{o}", "--effects", "none", "--seeds", "1", "--seconds", "16", "10", "--jobs", "1"],
}
IN_CI = ("sync",)
"""the others take longer, and come with XNECK_ROBUSTNESS"""


def started(words: list[str]) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "xneck", *words, "--quiet"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def outputs(folder: Path) -> list[Path]:
    """What a person sees; names that begin with a dot are no outputs."""
    return sorted(
        p for p in folder.rglob("*") if p.is_file() and not any(s.startswith(".") for s in p.relative_to(folder).parts)
    )


def whole(folder: Path) -> int:
    """How many outputs there are; every one can be read."""
    found = outputs(folder)
    for path in found:
        reader = BY_NAME.get(path.name) or BY_SUFFIX.get(path.suffix)
        if reader:
            reader(path)
    return len(found)


@pytest.mark.parametrize("name", COMMANDS if MORE > 1 else IN_CI)
def test_killed_at_any_time(name: str, recorded: Path, small: Path, tmp_path: Path) -> None:
    """First whole, to know how long it takes and what it writes; then killed at moments spread over that time, mostly its end,
    where files are written; then once more to its end in the same place."""
    places = {"r": recorded, "R": R, "s": small}
    first = tmp_path / "first"
    first.mkdir()
    begun = time.monotonic()
    process = started([word.format(**places, o=first) for word in COMMANDS[name]])
    assert process.wait() == 0, process.communicate()[1]
    lasts = time.monotonic() - begun
    here = tmp_path / "killed"
    here.mkdir()
    words = [word.format(**places, o=here) for word in COMMANDS[name]]
    rng = random.Random(name)
    for _ in range(2 if MORE == 1 else 3 * MORE):
        TRIED[f"killed: {name}"] += 1
        process = started(words)
        time.sleep(lasts * (1 - rng.random() ** 2 / 2))
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        whole(here)
    process = started(words)
    err = process.communicate()[1]
    assert process.returncode == 0, err
    whole(here)
    assert [p.relative_to(here) for p in outputs(here)] == [p.relative_to(first) for p in outputs(first)]
    assert list(here.rglob(".*.xneck-*")) == []


def halves(folder: Path) -> set[Path]:
    """Outputs that are being made, or were when their writer was killed. Folders may vanish while they are looked through."""
    found = (Path(here) / name for here, _, names in os.walk(folder) for name in names)
    return {path for path in found if path.name.startswith(".") and ".xneck-" in path.name}


def ended_within_an_output(words: list[str], folder: Path, at: int, delay_s: float) -> bool:
    """Kills a command when the output number `at` that it makes has begun, and a moment more; whether one was half made then."""
    process = started(words)
    before, begun = halves(folder), 0
    while process.poll() is None:
        now = halves(folder)
        begun += len(now - before)
        before |= now
        if begun > at:
            time.sleep(delay_s)
            os.killpg(process.pid, signal.SIGKILL)
            break
    process.communicate()
    return bool(halves(folder))


def outputs_begun(words: list[str], folder: Path) -> int:
    """How many outputs a whole run is seen to begin."""
    process = started(words)
    seen: set[Path] = set()
    while process.poll() is None:
        seen |= halves(folder)
    assert process.wait() == 0, process.communicate()[1]
    process.communicate()
    return len(seen)


@pytest.mark.parametrize("name", ("run", "sync", "diagnose", "calibrate", "study") if MORE > 1 else IN_CI)
def test_killed_while_an_output_is_made(name: str, recorded: Path, tmp_path: Path) -> None:
    """At moments when an output is there in part: nothing half is left under its name, and the same command then completes."""
    first, here = tmp_path / "first", tmp_path / "killed"
    first.mkdir()
    here.mkdir()
    places = {"r": recorded, "R": R}
    count = outputs_begun([word.format(**places, o=first) for word in COMMANDS[name]], first)
    words = [word.format(**places, o=here) for word in COMMANDS[name]]
    rng, inputs = random.Random(name), {path: path.read_bytes() for path in outputs(recorded)}
    hits, wanted = 0, 1 if MORE == 1 else 10
    for _ in range(20 * wanted):
        hits += ended_within_an_output(words, here, rng.randrange(count), rng.random() * 2e-3)
        whole(here)
        if hits == wanted:
            break
        for left in outputs(here) if rng.random() < 0.5 else ():
            left.unlink()  # so that outputs are made anew, not only taken over
    TRIED[f"killed while an output was half made: {name}"] += hits
    assert hits == wanted
    process = started(words)
    assert process.wait() == 0, process.communicate()[1]
    process.communicate()
    whole(here)
    assert [p.relative_to(here) for p in outputs(here)] == [p.relative_to(first) for p in outputs(first)]
    assert halves(here) == set()
    assert {path: path.read_bytes() for path in outputs(recorded)} == inputs


WRITES = """
import os, sys, time
from xneck_foundation.authorship import written_by_xneck
from xneck_foundation.whole_file import whole_file
with whole_file(sys.argv[1]) as part:
    part.write_text("half")
    print(part, flush=True)
    time.sleep(60)
"""


def test_what_a_killed_writer_left_is_swept_up_and_what_another_one_writes_is_not(tmp_path: Path) -> None:
    """Killed while it writes, which a command is only by chance; another process writes the same output all the time."""
    out = tmp_path / "a [1]*.md"
    left, other = (
        subprocess.Popen([sys.executable, "-c", WRITES, str(out)], stdout=subprocess.PIPE, text=True) for _ in range(2)
    )
    assert left.stdout
    assert other.stdout
    parts = [Path(one.stdout.readline().rstrip("\n")) for one in (left, other) if one.stdout]
    left.kill()
    left.communicate()
    TRIED["killed: a writer"] += 1
    assert not out.exists()
    assert all(part.read_text() == "half" for part in parts)
    with whole_file(out) as mine:
        mine.write_text("whole")
    assert out.read_text().startswith("whole\n")
    assert sorted(tmp_path.iterdir()) == sorted([out, parts[1]])
    other.kill()
    other.communicate()
