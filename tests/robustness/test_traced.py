"""What a command opens and whom it calls, as the kernel saw it: nothing outside of what it was given, and nobody."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import matplotlib
import pytest

from tests.paths import ROOT
from tests.robustness.judge import TRIED
from tests.robustness.sources import H
from tests.vision.test_video_file import LISTS

_OPENED = re.compile(r'\b(?:open|openat|creat)\((?:AT_FDCWD, |\d+<[^>]*>, )?"([^"]*)"[^)]*\) += \d')
_CALLED = re.compile(r"\bconnect\(.*sa_family=AF_INET")

pytestmark = pytest.mark.skipif(shutil.which("strace") is None, reason="needs strace")


class Traced(NamedTuple):
    """How a command ended, the files that it and its processes opened, and lines of calls to a network."""

    status: int
    opened: set[Path]
    calls: list[str]


def traced(folder: Path, *words: str | Path) -> Traced:
    """Of a command in `folder`."""
    status, lines = _lines(folder, "-m", "xneck", *map(str, words))
    TRIED["traced"] += 1
    return Traced(status, _opened(folder, lines), _calls(lines))


IN_TURN = """
import json, sys
from pathlib import Path
from xneck.cli import main
ended = []
for number, words in enumerate(json.loads(sys.argv[1])):
    Path(f"{number}.begun").touch()
    sys.argv = ["xneck", *words]
    try:
        main()
    except SystemExit as end:
        ended.append(end.code or 0)
Path("ended.json").write_text(json.dumps(ended))
"""


def traced_in_turn(folder: Path, commands: list[list[str]]) -> list[Traced]:
    """Of commands in `folder` by one process, which loads its libraries once: they count with the first."""
    status, lines = _lines(folder, "-c", IN_TURN, json.dumps(commands))
    assert status == 0
    begun = [i for i, line in enumerate(lines) if re.search(r'"\d+\.begun"', line)]
    assert len(begun) == len(commands)
    parts = [lines[a:b] for a, b in zip([0, *begun[1:]], [*begun[1:], len(lines)], strict=True)]
    TRIED["traced"] += len(parts)
    ended = json.loads((folder / "ended.json").read_text())
    return [Traced(status, _opened(folder, part), _calls(part)) for status, part in zip(ended, parts, strict=True)]


def _lines(folder: Path, *words: str) -> tuple[int, list[str]]:
    """Exit status of Python in `folder`, and what the kernel saw."""
    log = folder.parent / "trace"
    tracer = "strace -f --seccomp-bpf -qq -s 4096 -e trace=open,openat,creat,connect -o"
    prefix = [*tracer.split(), str(log)]
    ended = subprocess.run(
        [*prefix, sys.executable, *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        timeout=600,
        check=False,
    )
    return ended.returncode, log.read_text(errors="replace").splitlines()


def _opened(folder: Path, lines: list[str]) -> set[Path]:
    return {(folder / found[1]).resolve() for line in lines if (found := _OPENED.search(line))}


def _calls(lines: list[str]) -> list[str]:
    return [line for line in lines if _CALLED.search(line)]


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


class OfLists(NamedTuple):
    """Lists of every kind, each of a file by its whole name, of one in a network, and of one beside the folder."""

    secret: Path
    within: Path
    """where the commands ran"""
    by_name: dict[str, list[tuple[Path, Traced]]]
    """each list, and its command"""


@pytest.fixture(scope="module")
def of_lists(small: Path, tmp_path_factory: pytest.TempPathFactory) -> OfLists:
    home = tmp_path_factory.mktemp("lists")
    secret, within = home / "secret.mp4", home / "within"
    within.mkdir()
    shutil.copy(small / "video.mp4", secret)
    lists: list[Path] = []
    for number, target in enumerate((secret, "http://127.0.0.1:9/a.ts", "../secret.mp4")):
        here = home / str(number)
        here.mkdir()
        for file in ("camera.yaml", "neck.yaml"):
            shutil.copy(small / file, here / file)
        for name, (text, _) in LISTS.items():
            (here / name).write_text(text.format(target))
            lists.append(here / name)
    commands = [
        [
            "extract",
            str(video),
            "--camera",
            str(video.with_name("camera.yaml")),
            "--neck",
            str(video.with_name("neck.yaml")),
            "--out",
            str(video.with_name("a.mcap")),
        ]
        for video in lists
    ]
    done = list(zip(lists, traced_in_turn(within, commands), strict=True))
    by_name = {name: [one for one in done if one[0].name == name] for name in LISTS}
    return OfLists(secret, within, by_name)


@pytest.mark.parametrize("name", LISTS)
def test_a_video_that_names_others_opens_none(name: str, of_lists: OfLists) -> None:
    assert len(of_lists.by_name[name]) == 3
    for video, (status, opened, calls) in of_lists.by_name[name]:
        assert status == 1
        assert video in opened
        assert of_lists.secret not in opened
        assert outside(opened, of_lists.within, video.parent) == set()
        assert calls == []
