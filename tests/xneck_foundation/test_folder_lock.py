"""One run at a time in a folder; a run that was killed holds nothing."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from xneck_foundation.errors import Refused
from xneck_foundation.folder_lock import LOCK_FILE, only_run_in

HOLDER = """
import pathlib, sys, time
from xneck_foundation.folder_lock import only_run_in
with only_run_in(pathlib.Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def test_a_second_run_is_refused_until_the_first_ends_or_is_killed(tmp_path: Path) -> None:
    holder = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert holder.stdout is not None
    try:
        assert holder.stdout.readline() == "held\n"
        with pytest.raises(Refused, match=f"process {holder.pid} "), only_run_in(tmp_path):
            pass
    finally:
        holder.send_signal(signal.SIGKILL)
        holder.wait()
        holder.stdout.close()
    assert (tmp_path / LOCK_FILE).exists()
    with only_run_in(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_made_and_stays_only_where_something_is_in_it(tmp_path: Path) -> None:
    with only_run_in(tmp_path / "a"):
        pass
    with only_run_in(tmp_path / "b"):
        (tmp_path / "b" / "result").touch()
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(Refused, match="cannot be written"), only_run_in(tmp_path / "file" / "results"):
        pass
