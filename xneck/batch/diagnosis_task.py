"""One diagnosis as a task: its page, its record, and the arm's description and model with the cause in them, in one folder."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from diagnosis import extended_model, record
from diagnosis.deciding_motion import answers_json, deciding_motion
from diagnosis.diagnose import Diagnosis, diagnose
from identification.dataset.dataset import DataSet
from identification.dataset.dataset_file import export_series
from identification.dataset.stretches import Stretches, chosen_stretches, read_stretches
from identification.design.result import motion_series
from identification.design.trajectory import USUAL_LIMITS
from identification.model_file import write_model
from identification.pose_calibration import calibrated_model
from xneck.recording.result_files import (
    DATASET,
    DECIDING_MOTION,
    DIAGNOSIS_FILES,
    DIAGNOSIS_PAGE,
    DIAGNOSIS_RECORD,
    EXTENDED_MODEL,
    EXTENDED_NECK,
    REPORT,
    SUMMARY_PAGE,
)
from xneck.recording.software_versions import software_versions
from xneck.report.diagnosis_page import DiagnosisResult, PageLink, write_diagnosis_report
from xneck.report.diagnosis_text import diagnosis_sentence
from xneck_foundation.errors import Refused
from xneck_foundation.folder_lock import only_run_in
from xneck_foundation.json_text import json_text, read_record
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.provenance import note_inputs, provenance
from xneck_foundation.whole_file import check_output, write_text

DIAGNOSED_S, DIAGNOSED_STRETCHES = 130.0, 3
"""s of a recording that are diagnosed, and number of stretches where it is longer (docs/thresholds.md)"""
MAX_HELD_S = 300.0
"""s of all recordings of a diagnosis together, fitted and held out (docs/thresholds.md)"""


@one_blas_thread
def run_diagnosis_task(
    folder: Path,
    datasets: Sequence[Path],
    held_out: Sequence[Path],
    progress: Callable[[str], object] = lambda step: None,
    in_batch: bool = False,
) -> tuple[dict[str, Any], str]:
    """Writes all files of a diagnosis into `folder`, the record last; returns the record, and its text for a terminal.

    in_batch: whether a summary stands in the folder above, to which the page leads.

    Raises Refused as `diagnose` does, and before it begins where another run is at work in `folder`, or a file is there that
    xneck did not write.
    """
    with only_run_in(folder):
        for name in DIAGNOSIS_FILES:
            check_output(folder / name)
        return _diagnose_into(folder, datasets, held_out, progress, in_batch)


def _diagnose_into(
    folder: Path,
    datasets: Sequence[Path],
    held_out: Sequence[Path],
    progress: Callable[[str], object],
    in_batch: bool,
) -> tuple[dict[str, Any], str]:
    inputs = note_inputs(_input_paths(datasets, held_out))
    judged = dict(zip((*datasets, *held_out), _judged(datasets, held_out), strict=True))
    fitted, unfitted = (
        [data for path in paths for data in read_stretches(path, judged[path])] for paths in (datasets, held_out)
    )
    diagnosis = diagnose(fitted, unfitted, progress=progress)
    origin = provenance(inputs)
    result = record.as_json(diagnosis) | {
        "judged": [{"dataset": path.name, "held_out": path in held_out, **one.record} for path, one in judged.items()],
        "sentence": diagnosis_sentence(diagnosis),
        "motion": _deciding_motion(folder / DECIDING_MOTION, diagnosis, fitted),
        "provenance": origin,
        "made_from": _made_from(origin),
    }
    neck = extended_model.extended_description(diagnosis.extended_stage, fitted)
    write_text(folder / EXTENDED_NECK, extended_model.neck_yaml(neck))
    model = extended_model.extended_model(diagnosis.extended_stage, origin)
    posed = calibrated_model(model, fitted, neck)
    result["pose"] = posed.as_json()
    write_model(posed.model, folder / EXTENDED_MODEL)
    name = f"{' and '.join(map(_dataset_name, datasets))}, diagnosed"
    pages = tuple(_recording_pages(folder, [*datasets, *held_out]))
    summary = f"../{SUMMARY_PAGE}" if in_batch else None
    write_diagnosis_report(DiagnosisResult(name, diagnosis, origin, pages, summary), folder / DIAGNOSIS_PAGE)
    write_text(folder / DIAGNOSIS_RECORD, json_text(result))
    partly = [f"{path}: {one.text}" for path, one in judged.items() if not one.whole]
    return result, "\n".join([record.as_text(diagnosis) + posed.as_text(), *partly])


def _judged(datasets: Sequence[Path], held_out: Sequence[Path]) -> list[Stretches]:
    """What of each recording is held: all of those that are not longer than DIAGNOSED_S."""
    return chosen_stretches((*datasets, *held_out), DIAGNOSED_S, DIAGNOSED_STRETCHES, MAX_HELD_S)


def _recording_pages(folder: Path, datasets: Sequence[Path]) -> Iterator[PageLink]:
    """The pages of recordings that lie beside their data sets, as seen from a folder."""
    for dataset in datasets:
        page = dataset.resolve().parent / REPORT
        if page.is_file():
            href = os.path.relpath(page, folder.resolve()).replace(os.sep, "/")
            yield PageLink(page.parent.name, quote(href if href.startswith("../") else f"./{href}"))


def _deciding_motion(file: Path, diagnosis: Diagnosis, fitted: Sequence[DataSet]) -> dict[str, Any] | None:
    """Writes the motion that would settle the diagnosis, and says how; None, and no file, where nothing is open."""
    file.unlink(missing_ok=True)  # of an earlier diagnosis in this folder
    try:
        deciding = deciding_motion(diagnosis, fitted, USUAL_LIMITS)
    except Refused as refused:  # an arm for which no motion is found is diagnosed all the same
        return {"file": None, "why": str(refused)}
    if deciding is None:
        return None
    export_series(motion_series(deciding.designed.motion), file)
    return {"file": file.name, "effects": answers_json(deciding), "reached": deciding.designed.motion.reached()}


def stored_diagnosis(folder: Path, datasets: Sequence[Path], held_out: Sequence[Path]) -> dict[str, Any] | None:
    """The record in `folder`, or None where there is none, or it was made from other data or by other sources."""
    try:
        stored = read_record(folder / DIAGNOSIS_RECORD)
    except (OSError, ValueError):
        return None
    made_from = _made_from(provenance(note_inputs(_input_paths(datasets, held_out))))
    return stored if (folder / DIAGNOSIS_PAGE).is_file() and stored.get("made_from") == made_from else None


def _made_from(origin: Mapping[str, Any]) -> dict[str, Any]:
    return software_versions() | {"inputs": origin["inputs"]}


def _input_paths(datasets: Sequence[Path], held_out: Sequence[Path]) -> Mapping[str, Path]:
    fitted = {f"dataset{i + 1}": path for i, path in enumerate(datasets)}
    return fitted | {f"held_out{i + 1}": path for i, path in enumerate(held_out)}


def _dataset_name(dataset: Path) -> str:
    """The recording's name where the file lies in its folder of results, as all are called dataset.mcap there."""
    return dataset.resolve().parent.name if dataset.name == DATASET else dataset.stem
