"""Recordings of a batch: their names and lengths, and how they are made."""

import shutil
import sys
from pathlib import Path

import psutil

from tests.paths import SAMPLES

HELD_OUT = SAMPLES / "held_out"
NASTY = "<script>alert(1)<b> 100%20 & #1 'b' \"é雪"
FRAMES = 270
"""9 s of the sample"""
XNECK = [sys.executable, "-m", "xneck"]


def cut_short(folder: Path) -> None:
    """The start of the sample, its log cut off in the middle."""
    shutil.copytree(HELD_OUT, folder)
    rows = (HELD_OUT / "angles.csv").read_text().splitlines()
    (folder / "angles.csv").write_text("\n".join(rows[: FRAMES + 1]) + "\n")
    whole = (HELD_OUT / "log.mcap").read_bytes()
    (folder / "log.mcap").write_bytes(whole[: len(whole) * 5 // 8])


def worker_of(command: int) -> int | None:
    """The process in which a command's tasks run."""
    for process in psutil.Process(command).children(recursive=True):
        words = " ".join(process.cmdline()).lower()
        # where setproctitle is installed, as mutmut asks, Dask renames it
        if "spawn_main" in words or "dask worker" in words:
            return process.pid
    return None
