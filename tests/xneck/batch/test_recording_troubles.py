"""What stands in the way of writing is no fault of a recording: the next run tries again."""

from pathlib import Path

import pytest

import xneck.batch.recording_task
from tests.paths import SAMPLES
from xneck.batch.recording_task import run_recording_task
from xneck.recording.recording_folder import read_recording
from xneck.recording.result_folder import stored_refusal
from xneck_foundation.errors import Refused


@pytest.mark.parametrize("is_of_results", [True, False], ids=["results", "recording"])
def test_a_trouble_of_the_results_is_not_kept_and_one_of_the_recording_is(
    is_of_results: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording, folder = read_recording(SAMPLES / "held_out"), tmp_path / "held_out"
    where = folder / "report.html" if is_of_results else recording.log

    def refuse(*_: object) -> None:
        raise Refused(where, "cannot be used")

    monkeypatch.setattr(xneck.batch.recording_task, "run_stages", lambda *_: None)
    monkeypatch.setattr(xneck.batch.recording_task, "write_recording_report", refuse)
    with pytest.raises(Refused, match="cannot be used"):
        run_recording_task(recording, folder)
    assert stored_refusal(recording, folder) == (None if is_of_results else "log.mcap: cannot be used")
    assert [path.name for path in folder.iterdir()] == ([] if is_of_results else ["refused.json"])
