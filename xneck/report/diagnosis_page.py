"""One diagnosis as one HTML page that needs nothing beside itself."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diagnosis.advice import advice
from diagnosis.diagnose import Diagnosis
from xneck.report import diagnosis_figures as figures
from xneck.report import diagnosis_words as words
from xneck.report.block import Block
from xneck.report.figures_file import write_figures
from xneck.report.style import drawing
from xneck.report.template import render
from xneck.report.went_in import input_rows, version_text
from xneck.report.wording import listed
from xneck_foundation.whole_file import write_text


@dataclass(frozen=True)
class DiagnosisResult:
    """Everything that the page of a diagnosis shows."""

    name: str
    found: Diagnosis
    provenance: Mapping[str, Any]


def write_diagnosis_report(result: DiagnosisResult, path: Path) -> None:
    """The page with its figures' numbers beside it, whole or not at all; the same result gives the same bytes."""
    d = result.found
    motors, changed = d.extended.arm.M, bool(d.search.named)
    with drawing():
        drawn = {
            "proof_figure": figures.proof(d.signature, motors, changed),
            "alike_figure": figures.alike(d.sight),
            "time_figure": figures.over_time(d.signature, motors, changed),
            "condition_figure": figures.by_condition(d.signature, motors, changed),
        }
    write_figures(drawn.values(), path)
    write_text(path, page(result, drawn))


def page(result: DiagnosisResult, drawn: Mapping[str, Block | None]) -> str:
    """The HTML of a diagnosis."""
    d = result.found
    return render(
        "diagnosis.html.jinja",
        result=result,
        verdict=d.verdict,
        sentence=words.sentence(d),
        head=words.head(d),
        causes=words.cause_rows(d),
        channels=words.channel_table(d),
        gains=words.gain_table(d),
        considered=words.considered_rows(d),
        patterns=words.pattern_table(d),
        blind=listed(
            [words.spoken(name) for name in d.sight.blind]
            + [f"{words.spoken(name)} ({where})" for name, where in d.sight.unseen]
        ),
        steps=advice(d),
        inputs=input_rows(result.provenance),
        versions=version_text(result.provenance),
        **drawn,
    )
