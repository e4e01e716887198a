"""One diagnosis as one HTML page that needs nothing beside itself."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diagnosis.advice import advice
from diagnosis.diagnose import Diagnosis
from xneck.report import diagnosis_figures as figures
from xneck.report import diagnosis_text
from xneck.report.figure_block import FigureBlock
from xneck.report.figures_file import write_figures
from xneck.report.provenance_table import input_file_rows, version_text
from xneck.report.style import drawing
from xneck.report.template import render
from xneck.report.words import join_words, with_spaces
from xneck_foundation.whole_file import write_text


@dataclass(frozen=True)
class DiagnosisResult:
    """Everything that the page of a diagnosis shows."""

    name: str
    diagnosis: Diagnosis
    provenance: Mapping[str, Any]


def write_diagnosis_report(result: DiagnosisResult, path: Path) -> None:
    """The page with its figures' numbers beside it, whole or not at all; the same result gives the same bytes."""
    d = result.diagnosis
    motors, changed = d.extended.arm.M, bool(d.search.named)
    with drawing():
        drawn = {
            "proof_figure": figures.proof_figure(d.signature, motors, changed),
            "confusion_figure": figures.confusion_matrix(d.detectability),
            "time_figure": figures.residuals_over_time(d.signature, motors, changed),
            "condition_figure": figures.residuals_by_condition(d.signature, motors, changed),
        }
    write_figures(drawn.values(), path)
    write_text(path, diagnosis_html(result, drawn))


def diagnosis_html(result: DiagnosisResult, drawn: Mapping[str, FigureBlock | None]) -> str:
    """The HTML of a diagnosis's page."""
    d = result.diagnosis
    return render(
        "diagnosis.html.jinja",
        result=result,
        verdict=d.verdict,
        sentence=diagnosis_text.diagnosis_sentence(d),
        head=diagnosis_text.diagnosis_key_numbers(d),
        causes=diagnosis_text.cause_rows(d),
        channels=diagnosis_text.channel_table(d),
        gains=diagnosis_text.gain_table(d),
        drawing=diagnosis_text.drawing_rows(d),
        considered=diagnosis_text.considered_rows(d),
        patterns=diagnosis_text.pattern_table(d),
        blind=join_words(
            [with_spaces(name) for name in d.detectability.invisible]
            + [f"{with_spaces(name)} ({where})" for name, where in d.detectability.invisible_places]
        ),
        steps=advice(d),
        inputs=input_file_rows(result.provenance),
        versions=version_text(result.provenance),
        **drawn,
    )
