"""One recording as a task: all stages, the report, and at last result.json with what they were made from."""

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from identification.dataset.dataset_file import series_of
from identification.fasquelle.tables import as_json as fasquelle_json
from xneck.recording.made_from import made_from
from xneck.recording.pipeline import Result, run_recording
from xneck.recording.recording_folder import Recording
from xneck.recording.result_folder import (
    DATASET,
    FOXGLOVE,
    PLOTJUGGLER,
    REFUSED,
    REPORT,
    RERUN,
    RESULT,
    clear,
    files_in,
    within,
)
from xneck.report.page import write_report
from xneck.viewers.foxglove import foxglove_layout
from xneck.viewers.plotjuggler import plotjuggler_layout
from xneck.viewers.rerun_file import write_rerun
from xneck.viewers.rerun_sdk import rerun_sdk
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import as_json
from xneck_foundation.recovery import recoveries
from xneck_foundation.whole_file import write_text

_ONE = threading.Lock()
"""warnings and matplotlib's settings are the process's: on a worker with several threads one recording waits for the other"""


def run_one(
    recording: Recording, folder: Path, rerun: bool = False, stage: Callable[[str], object] = lambda name: None
) -> dict[str, Any]:
    """All files of a recording into `folder`, with `rerun` one for Rerun too, and its record; results that were there go first.

    Raises Refused; a refusal of what went in is kept in refused.json, as it would be the same again.
    """
    with _ONE, recoveries() as said:
        began = time.perf_counter()
        folder.mkdir(parents=True, exist_ok=True)
        clear(folder)
        if rerun:
            rerun_sdk(folder / RERUN)  # before the work: a worker of a cluster may lack it
        origin = made_from(recording)
        try:
            result = run_recording(recording, folder, stage)
            write_report(result, folder / REPORT)
            _write_viewed(result, folder, rerun)
        except Refused as refusal:
            if said:
                refusal = Refused(refusal.where, f"{refusal.what} ({'; '.join(said)})", refusal.do)
            if not Path(refusal.where).is_relative_to(folder):
                kept = {"refused": within(recording.folder, str(refusal)), "made_from": origin}
                write_text(folder / REFUSED, as_json(kept))
            raise refusal from refusal.__cause__
        record = _record(result) | {
            "recovered": [within(recording.folder, line) for line in said],
            "files": files_in(folder),
            "seconds": round(time.perf_counter() - began, 2),
            "made_from": origin,
        }
    text = as_json(record)
    write_text(folder / RESULT, text)
    return json.loads(text)


def _write_viewed(result: Result, folder: Path, rerun: bool) -> None:
    series = series_of(result.data)
    write_text(folder / FOXGLOVE, foxglove_layout(series))
    write_text(folder / PLOTJUGGLER, plotjuggler_layout(series, DATASET))
    if rerun:
        write_rerun(result, folder / RERUN)


def _record(result: Result) -> dict[str, Any]:
    """What the commands say in their --json, stage by stage; `report` is beside it."""
    out: dict[str, Any] = {
        "report": REPORT,
        "sync": dict(result.data.clock),
        "check": dict(result.data.check),
        "identify": result.estimates.as_json() | {"fasquelle": fasquelle_json(result.identification)},
        "simulate": result.simulated.rms if result.simulated else None,
    }
    if result.extraction:
        out["extract"] = result.extraction.as_json()
    return out
