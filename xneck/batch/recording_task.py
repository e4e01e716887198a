"""One recording as a task: all stages, the report, the viewers' files, and at last result.json with its fingerprint."""

import json
import threading
import time
from pathlib import Path
from typing import Any

from identification.dataset.dataset_file import dataset_series
from identification.fasquelle.tables import as_json as fasquelle_json
from xneck.recording.fingerprint import fingerprint
from xneck.recording.pipeline import run_stages
from xneck.recording.progress import StageProgress, no_progress
from xneck.recording.recording_folder import Recording
from xneck.recording.recording_result import RecordingResult
from xneck.recording.result_files import DATASET, FOXGLOVE, PLOTJUGGLER, REFUSED, REPORT, RERUN, RESULT, SUMMARY_PAGE
from xneck.recording.result_folder import check_apart, file_sizes, remove_results, without_folder
from xneck.report.model_adequacy import model_adequacy
from xneck.report.recording_page import write_recording_report
from xneck.viewers.foxglove import foxglove_layout
from xneck.viewers.plotjuggler import plotjuggler_layout
from xneck.viewers.rerun_file import write_rerun
from xneck.viewers.rerun_sdk import rerun_sdk
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_text
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.recovery import collected_recoveries
from xneck_foundation.whole_file import write_text

_TASK_LOCK = threading.Lock()
"""warnings and matplotlib's settings belong to the process: a worker with several threads runs one recording at a time"""


@one_blas_thread
def run_recording_task(
    recording: Recording,
    folder: Path,
    rerun: bool = False,
    progress: StageProgress = no_progress,
    in_batch: bool = False,
) -> dict[str, Any]:
    """Writes all files of a recording into `folder` and returns the record in result.json. Earlier results are removed first.

    `rerun`: whether to write recording.rrd too. `in_batch`: whether a summary stands in the folder above, to which the page leads.
    Raises Refused; where the inputs are to blame, refused.json keeps the line, as
    the next run would end the same.
    """
    with _TASK_LOCK, collected_recoveries() as warnings:
        start_s = time.perf_counter()
        folder.mkdir(parents=True, exist_ok=True)
        check_apart(recording, folder)
        remove_results(folder)
        if rerun:
            rerun_sdk(folder / RERUN)  # before the work: a worker of a cluster may lack it
        made_from = fingerprint(recording)
        try:
            result = run_stages(recording, folder, progress)
            write_recording_report(result, folder / REPORT, SUMMARY_PAGE if in_batch else None)
            _write_viewer_files(result, folder, rerun)
        except Refused as refusal:
            if warnings:
                refusal = Refused(refusal.where, f"{refusal.what} ({'; '.join(warnings)})", refusal.do)
            if not Path(refusal.where).is_relative_to(folder):
                refused = {"refused": without_folder(recording.folder, str(refusal)), "made_from": made_from}
                write_text(folder / REFUSED, json_text(refused))
            raise refusal from refusal.__cause__
        record = _record(result) | {
            "recovered": [without_folder(recording.folder, line) for line in warnings],
            "files": file_sizes(folder),
            "seconds": round(time.perf_counter() - start_s, 2),
            "made_from": made_from,
        }
    text = json_text(record)
    write_text(folder / RESULT, text)
    return json.loads(text)


def _write_viewer_files(result: RecordingResult, folder: Path, rerun: bool) -> None:
    series = dataset_series(result.data)
    write_text(folder / FOXGLOVE, foxglove_layout(series))
    write_text(folder / PLOTJUGGLER, plotjuggler_layout(series, DATASET))
    if rerun:
        write_rerun(result, folder / RERUN)


def _record(result: RecordingResult) -> dict[str, Any]:
    """The machine-readable results of the commands, stage by stage, and the name of the report."""
    adequacy = model_adequacy(result.simulated)
    record: dict[str, Any] = {
        "report": REPORT,
        "sync": dict(result.data.clock),
        "check": dict(result.data.check),
        "identify": result.estimates.as_json() | {"fasquelle": fasquelle_json(result.fasquelle)},
        "simulate": result.simulated.rms if result.simulated else None,
        "adequacy": adequacy.as_json() if adequacy else None,
    }
    if result.video is not None:
        record["extract"] = result.video.extraction.as_json()
    return record
