"""The folder of one recording's results: its files, whether they still hold, and the removal of what a killed run left."""

from pathlib import Path
from typing import Any

from xneck.recording.fingerprint import refreshed_if_unchanged
from xneck.recording.recording_folder import Recording
from xneck.recording.result_files import ALL_FILES, FIGURES, REFUSED, REPORT, RERUN, RESULT, STAGE_FILES, VIEWER_FILES
from xneck_foundation import whole_file
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_text, read_record
from xneck_foundation.same_file import same_file
from xneck_foundation.whole_file import write_text


def stored_result(recording: Recording, folder: Path, rerun: bool = False) -> dict[str, Any] | None:
    """The record in `folder`, or None where there is none, a file of it is missing, or its recording or the software changed.

    `rerun`: whether a recording.rrd must be among the files.
    """
    record = _read(folder / RESULT, recording)
    if record is None or any(
        not (file := folder / name).is_file() or file.stat().st_size != size for name, size in record["files"].items()
    ):
        return None
    return None if rerun and RERUN not in record["files"] else record


def stored_refusal(recording: Recording, folder: Path) -> str | None:
    """The line by which an earlier run refused this recording, or None where none did or the recording has changed."""
    record = _read(folder / REFUSED, recording)
    return None if record is None else record["refused"]


def file_sizes(folder: Path) -> dict[str, int]:
    """Sizes, in bytes, of the files that a result consists of, without result.json."""
    return {
        name: (folder / name).stat().st_size
        for name in (*STAGE_FILES, *VIEWER_FILES, REPORT, FIGURES)
        if (folder / name).is_file()
    }


def check_apart(recording: Recording, folder: Path) -> None:
    """Raises Refused where results in `folder` would replace a file of the recording, or one that xneck did not write."""
    for path in (recording.config, *recording.files.values()):
        name = next((name for name in ALL_FILES if same_file(folder / name, path)), None)
        if name is not None:
            what = f"its {name} would replace {path.name}, which the recording is made of"
            raise Refused(folder, what, "give --out another folder: no input is ever changed")
    for name in ALL_FILES:
        whole_file.check_output(folder / name)


def remove_results(folder: Path) -> None:
    """Removes the results, the record first. Other files in the folder stay."""
    for name in reversed(ALL_FILES):
        (folder / name).unlink(missing_ok=True)
    remove_partial_files(folder)


def remove_partial_files(folder: Path) -> None:
    """Removes partly written files that a killed process left."""
    for name in ALL_FILES:
        whole_file.remove_abandoned(folder / name)


def without_folder(recording: Path, line: str) -> str:
    """A line about files of a recording with paths relative to its folder, so that it is the same on any machine."""
    return line.removeprefix(f"{recording}: ").replace(f"{recording}/", "")


def _read(file: Path, recording: Recording) -> dict[str, Any] | None:
    """The record in a file if it was made from this recording as it is now; its times of change are brought up to date."""
    try:
        record = read_record(file)
    except (OSError, ValueError):
        return None
    before = record.get("made_from")
    present = None if before is None else refreshed_if_unchanged(before, recording)
    if present is None:
        return None
    if present != before:
        record["made_from"] = present
        write_text(file, json_text(record))
    return record
