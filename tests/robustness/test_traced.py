"""What a command opens and whom it calls, as the kernel saw it: nothing outside of what it was given, and nobody."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest

from tests.paths import ROOT
from tests.robustness.judge import TRIED
from tests.robustness.sources import H
from tests.vision.test_video_file import LISTS

_OPENED = re.compile(r'\b(?:open|openat|creat)\((?:AT_FDCWD, |\d+<[^>]*>, )?"([^"]*)"[^)]*\) += \d')
_CALLED = re.compile(r"\bconnect\(.*sa_family=AF_INET")

pytestmark = pytest.mark.skipif(shutil.which("strace") is None, reason="needs strace")


def traced(folder: Path, *words: str | Path) -> tuple[int, set[Path], list[str]]:
    """Exit status of a command in `folder`, the files that it and its processes opened there, and lines of calls to a network."""
    log = folder.parent / "trace"
    command = [sys.executable, "-m", "xneck", *map(str, words)]
    tracer = "strace -f --seccomp-bpf -qq -s 4096 -e trace=open,openat,creat,connect -o"
    prefix = [*tracer.split(), str(log)]
    ended = subprocess.run(
        [*prefix, *command], cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, timeout=600, check=False
    )
    lines = log.read_text(errors="replace").splitlines()
    opened = {(folder / found[1]).resolve() for line in lines if (found := _OPENED.search(line))}
    TRIED["traced"] += 1
    return ended.returncode, opened, [line for line in lines if _CALLED.search(line)]


def outside(opened: set[Path], *allowed: Path) -> set[Path]:
    """What was opened beside the folders allowed, the program itself, and the system's libraries and devices."""
    system = [*map(Path, ("/usr", "/lib", "/lib64", "/etc", "/proc", "/sys", "/dev", sys.prefix, sys.base_prefix))]
    program = [
        *map(Path, filter(None, sys.path)),
        ROOT,
        Path(sys.executable).resolve().parents[1],
        Path(matplotlib.get_cachedir()),
        Path(matplotlib.get_configdir()),
    ]
    places = [place.resolve() for place in (*allowed, *system, *program)]
    return {path for path in opened if not any(path.is_relative_to(place) for place in places)}


def test_a_recording_is_run_within_its_folder(tmp_path: Path) -> None:
    here = tmp_path / "recording"
    shutil.copytree(H, here)
    (tmp_path / "secret").mkdir()
    shutil.copy(H / "neck.yaml", tmp_path / "secret" / "neck.yaml")
    before = {path: path.read_bytes() for path in here.iterdir()}
    status, opened, calls = traced(here, "run", here, "--out", tmp_path / "results", "--quiet")
    assert status == 0
    assert here / "neck.yaml" in opened
    assert outside(opened, here, tmp_path / "results") == set()
    assert calls == []
    assert {path: path.read_bytes() for path in here.iterdir()} == before
    (here / "recording.yaml").write_text("angles: angles.csv\nlog: log.mcap\nneck: ../secret/neck.yaml\n")
    status, opened, calls = traced(here, "run", here, "--out", tmp_path / "results", "--quiet")
    assert status == 1
    assert tmp_path / "secret" / "neck.yaml" not in opened
    assert calls == []


@pytest.mark.parametrize("name", LISTS)
def test_a_video_that_names_others_opens_none(name: str, small: Path, tmp_path: Path) -> None:
    here, secret = tmp_path / "here", tmp_path / "secret.mp4"
    here.mkdir()
    shutil.copy(small / "video.mp4", secret)
    for file in ("camera.yaml", "neck.yaml"):
        shutil.copy(small / file, here / file)
    told = (
        "extract",
        here / name,
        "--camera",
        here / "camera.yaml",
        "--neck",
        here / "neck.yaml",
        "--out",
        here / "a.mcap",
    )
    for target in (secret, "http://127.0.0.1:9/a.ts", "../secret.mp4"):
        (here / name).write_text(LISTS[name][0].format(target))
        status, opened, calls = traced(here, *told)
        assert status == 1
        assert here / name in opened
        assert secret not in opened
        assert outside(opened, here) == set()
        assert calls == []
