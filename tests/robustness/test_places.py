"""Where files are: names of any letters, folders that cannot be written, full disks, and things that are no files."""

import os
import resource
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from identification.dataset.dataset_file import read_dataset
from tests.paths import ROOT
from tests.robustness.judge import TRIED, Ran, check, run
from tests.robustness.sources import H, R

LIMIT_S = 60


def outside(kind: str, *words: str | Path, most: int | None = None) -> Ran:
    """`xneck` with these words as a process of its own, which may write files of `most` bytes and is let run for LIMIT_S."""
    TRIED[kind] += 1

    def limit() -> None:
        if most is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

    ended = subprocess.run(
        [sys.executable, "-m", "xneck", *map(str, words)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        errors="surrogateescape",
        timeout=LIMIT_S,
        stdin=subprocess.DEVNULL,
        preexec_fn=limit,
        check=False,
    )
    return Ran(ended.returncode, ended.stdout, ended.stderr)


def sync(recorded: Path, out: Path) -> list[str | Path]:
    return ["sync", recorded / "angles.csv", recorded / "log.csv", "--neck", recorded / "neck.yaml", "--out", out]


@pytest.mark.parametrize("name", ["größe-腱駆動-🦒 a  b", "-dash", "quote'\"$(x)`100%{}[]*?", "new\nline", "x" * 120])
def test_names_of_any_letters(name: str, recorded: Path, tmp_path: Path) -> None:
    here = tmp_path / name
    shutil.copytree(recorded, here)
    (here / "out").mkdir()
    out = here / "out" / f"{name}.mcap"
    check(run("names", *sync(here, out), "--quiet"), {out: read_dataset}, (here,))
    ran = run("names", "check", out, "--json", here / "out.json", "--quiet")
    check(ran, {out: read_dataset}, (out,))
    (here / "log.csv").write_text("")
    ran = run("names", *sync(here, here / "d.mcap"))
    assert ran.status == 1
    assert ran.err.count("\n") == 1
    assert "log.csv: is empty" in ran.err


def test_names_that_are_no_utf_8_are_refused_before_any_work(recorded: Path, tmp_path: Path) -> None:
    here = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff\xfe"))
    shutil.copytree(recorded, here)
    (here / "out").mkdir()
    ran = outside("names", *sync(here, here / "out/d.mcap"))
    assert ran.status == 1
    assert ran.err.count("\n") == 1
    assert r"\xff\xfe/angles.csv: is not written in UTF-8" in ran.err
    assert list((here / "out").iterdir()) == []


READERS: dict[str, list[str]] = {
    "angles": ["sync", "X", "{r}/log.csv", "--neck", "{r}/neck.yaml", "--out", "{o}/d.mcap"],
    "angles.mcap": ["sync", "X.mcap", "{r}/log.csv", "--neck", "{r}/neck.yaml", "--out", "{o}/d.mcap"],
    "log": ["sync", "{r}/angles.csv", "X", "--neck", "{r}/neck.yaml", "--out", "{o}/d.mcap"],
    "log.mcap": ["sync", "{r}/angles.csv", "X.mcap", "--neck", "{r}/neck.yaml", "--out", "{o}/d.mcap"],
    "neck": ["sync", "{r}/angles.csv", "{r}/log.csv", "--neck", "X", "--out", "{o}/d.mcap"],
    "data set": ["identify", "X", "--out", "{o}/m.yaml"],
    "checked": ["check", "X", "--json", "{o}/c.json"],
    "baseline": ["check", "{r}/d.mcap", "--baseline", "X", "--json", "{o}/c.json"],
    "model": ["simulate", "{r}/d.mcap", "--model", "X", "--out", "{o}/s.mcap"],
    "fitted": ["diagnose", "X", "--held-out", "{r}/d.mcap", "--out", "{o}/x"],
    "design": ["design", "X", "--out", "{o}/m.csv"],
    "video": ["extract", "X", "--camera", "{R}/camera.yaml", "--neck", "{R}/neck.yaml", "--out", "{o}/a.mcap"],
    "picture": ["calibrate", "X", "--board", "{R}/board.yaml", "--out", "{o}/c.yaml"],
    "board": ["calibrate", "{R}/board/01.jpg", "--board", "X", "--out", "{o}/c.yaml"],
    "held camera": [
        "calibrate",
        "{R}/board/01.jpg",
        "--board",
        "{R}/board.yaml",
        "--check",
        "X",
        "--json",
        "{o}/c.json",
    ],
    "printed": ["board", "X", "--out", "{o}/b.pdf"],
    "recording": ["run", "X", "--out", "{o}/x"],
}


@pytest.mark.parametrize(
    "what", ["nothing", "empty", "folder", "pipe", "device", "endless", "loop", "socket", "zeros", "long name"]
)
def test_what_is_no_file_is_refused_and_not_waited_for(what: str, recorded: Path, small: Path, tmp_path: Path) -> None:
    """A pipe that nobody writes to would be waited for, /dev/zero be read for ever."""
    out = tmp_path / "out"
    out.mkdir()
    for number, (name, words) in enumerate(READERS.items()):
        if (name, what) in {("picture", "folder"), ("recording", "folder")}:
            continue  # they may be folders
        suffix = ".mcap" if "X.mcap" in words else ""
        it = tmp_path / f"it{number}{suffix}"
        if what == "empty":
            it.touch()
        elif what == "folder":
            it.mkdir()
        elif what == "pipe":
            os.mkfifo(it)
        elif what in ("device", "endless"):
            it.symlink_to("/dev/null" if what == "device" else "/dev/zero")
        elif what == "loop":
            it.symlink_to(it.name)
        elif what == "socket":
            with socket.socket(socket.AF_UNIX) as server:
                server.bind(os.path.relpath(it))
        elif what == "zeros":
            it.write_bytes(bytes(5000))
        elif what == "long name":
            it = tmp_path / ("x" * 300 + suffix)
        places = {"r": recorded, "R": small if "camera" in " ".join(words) else R, "o": out}
        given = [str(it) if word in ("X", "X.mcap") else word.format(**places) for word in words]
        check(run(f"no file: {what}", *given), {out / "never": read_dataset}, (it,))


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is read-only for root")
def test_a_folder_that_is_read_only(recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir(mode=0o555)
    check(
        run("places", *sync(recorded, tmp_path / "out/d.mcap")),
        {tmp_path / "out/d.mcap": read_dataset},
        (tmp_path / "out",),
    )


def test_places_that_cannot_be_written(recorded: Path, small: Path, tmp_path: Path) -> None:
    """/proc is read-only for root too. A device stands in as a link to it, for who writes it by name may have replaced it."""
    here, pipe, device = tmp_path / "file", tmp_path / "pipe", tmp_path / "null"
    here.touch()
    os.mkfifo(pipe)
    device.symlink_to("/dev/null")
    for out in (Path("/proc/d.mcap"), here / "d.mcap", tmp_path, pipe, device, tmp_path / ("x" * 300)):
        for words in (
            [*sync(recorded, out)],
            ["identify", recorded / "d.mcap", "--out", out],
            ["check", recorded / "d.mcap", "--json", out],
        ):
            ran = run("places", *words)
            assert ran.status == 1, ran
            assert ran.err.count("\n") == 1, ran.err
    loop = tmp_path / "loop"
    loop.symlink_to("loop")
    for out in (Path("/proc/results"), here, here / "results", loop, loop / "results"):
        ran = run("places", "run", H, "--out", out)
        assert ran.status in (1, 2), ran
        assert ran.status == 2 or ran.err.count("\n") == 1, ran.err
    assert here.read_bytes() == b""
    assert pipe.is_fifo()
    assert device.is_symlink()
    assert sorted(tmp_path.iterdir()) == sorted([here, pipe, device, loop])


@pytest.mark.parametrize("most", [0, 300_000])
def test_a_full_disk(most: int, recorded: Path, tmp_path: Path) -> None:
    """As a limit on the size of files, which stops every write as a full disk does: no part is left, and what was there stays."""
    out = tmp_path / "out"
    out.mkdir()
    shutil.copy(recorded / "d.mcap", out / "d.mcap")
    before = (out / "d.mcap").read_bytes()
    for words in (
        [*sync(recorded, out / "d.mcap")],
        ["simulate", recorded / "d.mcap", "--model", recorded / "m.yaml", "--out", out / "d.mcap", "--export", "npz"],
    ):
        ran = outside("full disk", *words, most=most)
        assert ran.status == 1, ran
        assert ran.err == f"xneck: {out / 'd.mcap'}: cannot be written (File too large)\n"
        assert ran.out == ""
        assert [p.read_bytes() for p in out.iterdir()] == [before]
