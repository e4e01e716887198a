"""The folder of one diagnosis: its page, its record, and the arm's description and model with the cause in them."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from diagnosis import extended_model, record
from diagnosis.diagnose import diagnose
from identification.dataset.dataset_file import read_dataset
from identification.model_file import write_model
from xneck.recording.made_from import makers
from xneck.recording.result_folder import DATASET
from xneck.report.diagnosis_page import DiagnosisResult, write_diagnosis_report
from xneck.report.diagnosis_words import sentence
from xneck_foundation.json_text import as_json
from xneck_foundation.provenance import provenance
from xneck_foundation.whole_file import write_text

PAGE = "diagnosis.html"
RECORD = "diagnosis.json"


def diagnose_into(
    folder: Path, datasets: Sequence[Path], held_out: Sequence[Path], told: Callable[[str], object] = lambda step: None
) -> tuple[dict[str, Any], str]:
    """All files of a diagnosis into `folder`, the record last; the record, and what it says to a person on a terminal."""
    fitted, others = [read_dataset(p) for p in datasets], [read_dataset(p) for p in held_out]
    found = diagnose(fitted, others, progress=told)
    origin = provenance(_inputs(datasets, held_out))
    result = record.as_json(found) | {
        "sentence": sentence(found),
        "provenance": origin,
        "made_from": _made_from(origin),
    }
    folder.mkdir(parents=True, exist_ok=True)
    write_text(
        folder / "neck.yaml", extended_model.neck_yaml(extended_model.description(found.search.last, found.extended))
    )
    write_model(extended_model.model(found.search.last, found.extended, origin), folder / "model.yaml")
    name = f"{' and '.join(map(_called, datasets))}, diagnosed"
    write_diagnosis_report(DiagnosisResult(name, found, origin), folder / PAGE)
    write_text(folder / RECORD, as_json(result))
    return result, record.as_text(found)


def diagnosis_of(folder: Path, datasets: Sequence[Path], held_out: Sequence[Path]) -> dict[str, Any] | None:
    """The record in `folder`, or None where there is none, or it was made from other data or by other sources."""
    try:
        known = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    now = _made_from(provenance(_inputs(datasets, held_out)))
    return known if (folder / PAGE).is_file() and known.get("made_from") == now else None


def _made_from(origin: Mapping[str, Any]) -> dict[str, Any]:
    return makers() | {"inputs": origin["inputs"]}


def _inputs(datasets: Sequence[Path], held_out: Sequence[Path]) -> Mapping[str, Path]:
    fitted = {f"dataset{i + 1}": path for i, path in enumerate(datasets)}
    return fitted | {f"held_out{i + 1}": path for i, path in enumerate(held_out)}


def _called(dataset: Path) -> str:
    """By its recording where it lies in that one's folder of results, where all have the same name."""
    return dataset.resolve().parent.name if dataset.name == DATASET else dataset.stem
