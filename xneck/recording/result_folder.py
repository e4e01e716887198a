"""The folder of one recording's results: what is in it, whether it still holds, and what a killed run left there."""

import json
from pathlib import Path
from typing import Any

from xneck.recording.made_from import unchanged
from xneck.recording.recording_folder import Recording
from xneck_foundation import whole_file
from xneck_foundation.json_text import as_json
from xneck_foundation.whole_file import write_text

RESULT = "result.json"
REPORT = "report.html"
FIGURES = "report.figures.json"
REFUSED = "refused.json"
RERUN = "recording.rrd"
FOXGLOVE = "foxglove.json"
PLOTJUGGLER = "plotjuggler.xml"
VIEWED = (FOXGLOVE, PLOTJUGGLER, RERUN)
"""files for other people's viewers; the last on request only"""
DATASET = "dataset.mcap"
STAGES = ("camera.yaml", "angles.mcap", DATASET, "model.yaml", "simulated.mcap")
"""files that the stages may write"""
_ALL = (*STAGES, *VIEWED, REPORT, FIGURES, RESULT, REFUSED)


def result_of(recording: Recording, folder: Path, rerun: bool = False) -> dict[str, Any] | None:
    """The record in `folder`, or None where there is none, a file of it is missing, or it was made from something else.

    `rerun`: it is to have a recording.rrd.
    """
    record = _read(folder / RESULT, recording)
    if record is None or any(
        not (file := folder / name).is_file() or file.stat().st_size != size for name, size in record["files"].items()
    ):
        return None
    return None if rerun and RERUN not in record["files"] else record


def refusal_of(recording: Recording, folder: Path) -> str | None:
    """The line by which an earlier run refused the same recording."""
    record = _read(folder / REFUSED, recording)
    return None if record is None else record["refused"]


def files_in(folder: Path) -> dict[str, int]:
    """Sizes of the files that a result consists of, result.json apart."""
    return {
        name: (folder / name).stat().st_size
        for name in (*STAGES, *VIEWED, REPORT, FIGURES)
        if (folder / name).is_file()
    }


def clear(folder: Path) -> None:
    """Removes results, the record first; what else is in the folder stays."""
    for name in reversed(_ALL):
        (folder / name).unlink(missing_ok=True)
    sweep(folder)


def sweep(folder: Path) -> None:
    """Removes the parts of files that a killed process left."""
    for name in _ALL:
        whole_file.sweep(folder / name)


def within(recording: Path, line: str) -> str:
    """A line about the files of a recording as it reads inside its folder, the same on any machine."""
    return line.removeprefix(f"{recording}: ").replace(f"{recording}/", "")


def _read(file: Path, recording: Recording) -> dict[str, Any] | None:
    """A record made from this recording as it is; its times of change are brought up to date."""
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    before = record.get("made_from")
    now = None if before is None else unchanged(before, recording)
    if now is None:
        return None
    if now != before:
        record["made_from"] = now
        write_text(file, as_json(record))
    return record
