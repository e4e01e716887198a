"""One diagnosis as one HTML page that needs nothing beside itself."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diagnosis.advice import advice
from diagnosis.cause_picture import free_function_picture
from diagnosis.diagnose import Diagnosis
from diagnosis.worth_naming import MIN_EXPLAINED
from xneck.report import diagnosis_figures as figures
from xneck.report import diagnosis_text
from xneck.report.arm_overview import arm_overview
from xneck.report.cause_figures import cause_figure, law_figure, unlisted_figure
from xneck.report.figure_block import FigureBlock
from xneck.report.figures_file import write_figures
from xneck.report.provenance_table import input_file_rows, version_text
from xneck.report.style import drawing
from xneck.report.template import render
from xneck.report.words import join_words, with_spaces
from xneck_foundation.whole_file import write_text


@dataclass(frozen=True)
class PageLink:
    """Another page that is there, by its name and its address relative to this one."""

    name: str
    href: str


@dataclass(frozen=True)
class DiagnosisResult:
    """Everything that the page of a diagnosis shows."""

    name: str
    diagnosis: Diagnosis
    provenance: Mapping[str, Any]
    recordings: tuple[PageLink, ...] = ()
    """pages of the recordings that it was made from, as far as they are there"""
    summary: str | None = None
    """address of the summary of all recordings, relative to this page; None where there is none"""


@dataclass(frozen=True)
class DrawnFigures:
    """The figures of a page; None where it goes without."""

    overview: FigureBlock
    proof: tuple[FigureBlock, ...]
    laws: tuple[FigureBlock, ...]
    unlisted: FigureBlock | None
    confusion: FigureBlock
    over_time: FigureBlock
    by_condition: FigureBlock | None

    @property
    def all(self) -> tuple[FigureBlock | None, ...]:
        """In the page's order."""
        return (
            self.overview,
            *self.proof,
            *self.laws,
            self.unlisted,
            self.confusion,
            self.over_time,
            self.by_condition,
        )


def write_diagnosis_report(result: DiagnosisResult, path: Path) -> None:
    """The page with its figures' numbers beside it, whole or not at all; the same result gives the same bytes."""
    with drawing():
        drawn = diagnosis_figures(result.diagnosis)
    write_figures(drawn.all, path)
    write_text(path, diagnosis_html(result, drawn))


def diagnosis_figures(d: Diagnosis) -> DrawnFigures:
    """All figures of a diagnosis; to be called within `style.drawing`."""
    motors, changed = d.extended.arm.M, d.is_extended
    rest = None if d.found_laws else d.search.unlisted
    return DrawnFigures(
        overview=arm_overview(d),
        proof=_proof_figures(d),
        laws=_law_figures(d),
        unlisted=rest and unlisted_figure(rest, free_function_picture(d.search.last, rest), motors),
        confusion=figures.confusion_matrix(d.detectability),
        over_time=figures.residuals_over_time(d.signature, motors, changed),
        by_condition=figures.residuals_by_condition(d.signature, motors, changed),
    )


def _proof_figures(d: Diagnosis) -> tuple[FigureBlock, ...]:
    """One for each cause. Where none is named: what stands out most, but where a law that nobody listed explains most."""
    if d.causes:
        pairs = zip(d.causes, d.pictures[: len(d.causes)], strict=True)
        return tuple(
            cause_figure(cause, picture, d.extended.arm, number, of=len(d.causes))
            for number, (cause, picture) in enumerate(pairs, start=1)
        )
    if d.found_laws:
        return ()
    if d.search.unlisted and d.search.unlisted.explains >= MIN_EXPLAINED:
        return ()
    return (figures.proof_figure(d.signature, d.extended.arm.M),)


def _law_figures(d: Diagnosis) -> tuple[FigureBlock, ...]:
    """One for each law that was found."""
    if not d.found_laws:
        return ()
    pairs = enumerate(zip(d.found_laws, d.pictures[len(d.causes) :], strict=True), start=1)
    return tuple(law_figure(found, picture, d.extended.arm.M, number) for number, (found, picture) in pairs)


def diagnosis_html(result: DiagnosisResult, drawn: DrawnFigures) -> str:
    """The HTML of a diagnosis's page."""
    d = result.diagnosis
    return render(
        "diagnosis.html.jinja",
        result=result,
        verdict=d.verdict,
        recordings=result.recordings,
        summary=result.summary,
        sentence=diagnosis_text.diagnosis_sentence(d),
        head=diagnosis_text.diagnosis_key_numbers(d),
        causes=diagnosis_text.cause_rows(d),
        shares=diagnosis_text.share_rows(d),
        laws=diagnosis_text.law_rows(d),
        unlisted=diagnosis_text.unlisted_sentence(d),
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
        drawn=drawn,
    )
