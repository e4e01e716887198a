"""Partly written files go with the results, and nothing else."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from tests.paths import SAMPLES
from xneck.batch.recording_task import run_recording_task
from xneck.recording.fingerprint import fingerprint
from xneck.recording.recording_folder import read_recording
from xneck.recording.result_folder import file_sizes, remove_partial_files, remove_results, stored_result
from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import replacing_any_file, whole_file, write_text


def test_what_a_killed_writer_left_goes_with_the_results(tmp_path: Path) -> None:
    """A part as whole_file itself makes it, of every output; what the writer still holds stays, and a person's own files."""
    for name in ("dataset.mcap", "report.html"):
        with whole_file(tmp_path / name) as part:
            left = part.with_name(part.name[: -len(part.suffix) - 8] + "0a1b2c3d" + part.suffix)
            shutil.copy(part, left)
            remove_partial_files(tmp_path)
            assert part.exists()
            assert not left.exists()
    (tmp_path / ".report-of-mine.html").touch()
    remove_results(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".report-of-mine.html"]


def test_results_never_replace_what_the_recording_is_made_of(tmp_path: Path) -> None:
    """`xneck run monday --out .` would write its results into the recording, where camera.yaml is xneck's own."""
    here, linked, other = tmp_path / "monday", tmp_path / "linked", tmp_path / "other"
    shutil.copytree(SAMPLES / "held_out", here)
    write_text(here / "camera.yaml", "a: 1\n")
    (here / "video.mp4").touch()
    files = {"angles": None, "camera": here / "camera.yaml", "video": here / "video.mp4"}
    recording = replace(read_recording(here), **files)
    linked.symlink_to(here)
    other.mkdir()
    (other / "model.yaml").hardlink_to(here / "neck.yaml")
    before = contents(here)
    for folder, result, file in ((here, "camera", "camera"), (linked, "camera", "camera"), (other, "model", "neck")):
        sentence = rf"its {result}\.yaml would replace {file}\.yaml, which the recording is made of"
        with pytest.raises(Refused, match=sentence), replacing_any_file():
            run_recording_task(recording, folder)
        assert contents(here) == before


def test_a_persons_file_among_the_results_is_kept(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("<p>mine</p>")
    with pytest.raises(Refused, match="give --force"):
        run_recording_task(read_recording(SAMPLES / "held_out"), tmp_path)
    assert contents(tmp_path) == {"report.html": b"<p>mine</p>"}


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_result_that_was_cut_off_or_lost_does_not_count_as_done(tmp_path: Path) -> None:
    """A disk that was full, a copy that broke off: a record beside files that are not what it says is none."""
    recording, folder = read_recording(SAMPLES / "held_out"), tmp_path
    for name in ("dataset.mcap", "model.yaml"):
        (folder / name).write_bytes(b"0123456789")
    record = {"made_from": fingerprint(recording), "files": file_sizes(folder), "verdict": "consistent"}
    write_text(folder / "result.json", json.dumps(record))
    stored = stored_result(recording, folder)
    assert stored is not None
    assert stored["verdict"] == "consistent"
    assert stored["files"] == {"dataset.mcap": 10, "model.yaml": 10}
    assert stored_result(recording, folder, rerun=True) is None
    for damaged in (b"012345678", b"01234567890", b""):
        (folder / "model.yaml").write_bytes(damaged)
        assert stored_result(recording, folder) is None
    (folder / "model.yaml").unlink()
    assert stored_result(recording, folder) is None
    (folder / "model.yaml").write_bytes(b"0123456789")
    assert stored_result(recording, folder) == stored
