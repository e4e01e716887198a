"""Files are hashed only where their time of change differs."""

import json
from pathlib import Path

import pytest

import xneck.batch.recording_task
import xneck.batch.run_batch
import xneck.recording.fingerprint
from tests.paths import SAMPLES
from xneck.recording.fingerprint import fingerprint, refreshed_if_unchanged
from xneck.recording.recording_folder import read_recording


def test_a_hash_is_taken_only_where_a_time_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    recording = read_recording(SAMPLES / "held_out")
    origin = fingerprint(recording)
    read: list[Path] = []
    monkeypatch.setattr(xneck.recording.fingerprint, "sha256", lambda path: read.append(path) or "another")
    assert refreshed_if_unchanged(origin, recording) == origin
    assert read == []
    later = json.loads(json.dumps(origin))
    later["inputs"]["log"]["mtime_ns"] -= 1
    assert refreshed_if_unchanged(later, recording) is None
    assert read == [recording.log]
