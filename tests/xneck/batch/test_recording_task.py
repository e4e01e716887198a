"""Recordings in one process keep their warnings apart."""

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import xneck.batch.recording_task
import xneck.batch.run_batch
import xneck.recording.fingerprint
from xneck.batch.recording_task import run_recording_task
from xneck.recording.recording_folder import read_recording
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import warn_recovered


def test_recordings_in_one_process_hear_their_own_warnings(
    recordings: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a worker with several threads: warnings go to whoever listens last."""
    recording = read_recording(next(path for path in recordings if path.name == "cut"))

    def stages(_: Any, folder: Path, __: Any) -> None:
        time.sleep(0.1)
        warn_recovered(folder.name, "is cut off")
        time.sleep(0.1)
        raise Refused("here", "stop")

    monkeypatch.setattr(xneck.batch.recording_task, "run_stages", stages)
    with ThreadPoolExecutor(2) as threads:
        ended = {name: threads.submit(run_recording_task, recording, tmp_path / name) for name in ("a", "b")}
    assert {name: str(one.exception()) for name, one in ended.items()} == {
        name: f"here: stop ({name}: is cut off)" for name in ("a", "b")
    }
    assert {path.parent.name for path in tmp_path.glob("*/refused.json")} == {"a", "b"}
