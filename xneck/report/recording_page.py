"""One recording as one HTML page that needs nothing beside itself."""

from collections.abc import Mapping
from pathlib import Path

from identification.estimate_table import LED_ASTRAY
from identification.fasquelle.method import MAX_RELATIVE_SIGMA_PERCENT
from identification.fasquelle.reconstruction import Reconstruction, reconstruct
from identification.identifiability import durbin_wu_hausman
from mechanism.elasticity import ELASTIC_MODELS
from synchronisation.check.explained_elongation import explain
from xneck.recording.recording_result import RecordingResult
from xneck.report import (
    cable_figures,
    fasquelle_figures,
    fasquelle_published,
    motion_figures,
    recording_summary,
    recording_tables,
    simulation_figures,
)
from xneck.report.clock_alignment import clock_alignment
from xneck.report.fasquelle_table import fasquelle_table
from xneck.report.figure_block import FigureBlock
from xneck.report.figures_file import write_figures
from xneck.report.model_adequacy import DIAGNOSE_COMMAND, UNEXPLAINED_RATIO, model_adequacy
from xneck.report.number_text import number_text
from xneck.report.provenance_table import input_file_rows, version_text
from xneck.report.style import drawing
from xneck.report.template import render
from xneck_foundation.whole_file import write_text

SIGNIFICANCE = 0.05
"""p below which the Durbin-Wu-Hausman test says that least squares would be biased (docs/thresholds.md)"""
_NO_CAMERA: dict[str, object] = {
    "camera": None,
    "calibration": None,
    "extraction": None,
    "frame_cuts": [],
    "film": None,
}
"""the template's values where the angles came as a file"""


def write_recording_report(result: RecordingResult, path: Path, summary: str | None = None) -> None:
    """The page with its figures' numbers beside it, whole or not at all; the same result gives the same bytes.

    summary: name of the summary's page in the folder above, to which it leads; None where there is none.
    """
    reconstruction = reconstruct(result.data, result.fasquelle)
    figures = _figures(result, reconstruction)
    write_figures(figures.values(), path)
    write_text(path, recording_html(result, reconstruction, figures, summary))


def recording_html(
    result: RecordingResult,
    reconstruction: Reconstruction,
    figures: Mapping[str, FigureBlock | None],
    summary: str | None = None,
) -> str:
    """The HTML of a recording's page, with everything that it shows inside."""
    fasquelle, cables = result.fasquelle, result.data.neck.M
    hausman = durbin_wu_hausman(result.estimates.solution)[1]
    return render(
        "report.html.jinja",
        result=result,
        summary=summary,
        data=result.data,
        sentence=recording_summary.summary_sentence(result),
        head=recording_summary.key_numbers(result),
        adequacy=model_adequacy(result.simulated),
        unexplained_ratio=UNEXPLAINED_RATIO,
        diagnose_command=DIAGNOSE_COMMAND,
        tables=recording_tables,
        inputs=input_file_rows(result.data.provenance),
        versions=version_text(result.data.provenance),
        table_1=fasquelle_table(
            "Table 1: friction, from the arm equations",
            [fasquelle.dry_and_viscous, fasquelle.dry_only],
            fasquelle_published.TABLE_1,
            cables,
        ),
        table_2=fasquelle_table(
            "Table 2: friction and elasticity",
            [fasquelle.elastic[m] for m in ELASTIC_MODELS],
            fasquelle_published.TABLE_2,
            cables,
        ),
        mean_errors=[(m, fasquelle.mean_error(m)) for m in ELASTIC_MODELS],
        led_astray=LED_ASTRAY if result.estimates.solution.is_least_squares else None,
        hausman=hausman,
        least_squares_biased=hausman < SIGNIFICANCE,
        published=fasquelle_published,
        number=number_text,
        well_identified=MAX_RELATIVE_SIGMA_PERCENT,
        couple_errors=fasquelle_figures.couple_errors(reconstruction),
        **_camera_section(result),
        **figures,
    )


def _figures(result: RecordingResult, reconstruction: Reconstruction) -> dict[str, FigureBlock | None]:
    """The page's figures by their names in the template."""
    data = result.data
    alignment, elongation = clock_alignment(data), explain(data.arm, data.state)
    with drawing():
        return {
            "calibration_figure": _calibration_figure(result),
            "alpha_figure": motion_figures.alpha_over_time(data),
            "travel_figure": motion_figures.travel_on_both_clocks(data, alignment),
            "clock_figure": motion_figures.clock_evidence(data, alignment),
            "elongation_figure": cable_figures.elongation_over_time(data, elongation),
            "force_figure": cable_figures.elongation_against_force(data, elongation),
            "couple_figure": fasquelle_figures.couples(reconstruction),
            "tension_figure": fasquelle_figures.tensions(reconstruction),
            "error_figure": fasquelle_figures.tension_errors(reconstruction),
            "simulation_figure": (
                simulation_figures.simulated_beside_measured(result.simulated) if result.simulated else None
            ),
        }


def _calibration_figure(result: RecordingResult) -> FigureBlock | None:
    if result.video is None:
        return None
    from xneck.report.camera_section import calibration_figure  # needs OpenCV

    return calibration_figure(result.video)


def _camera_section(result: RecordingResult) -> Mapping[str, object]:
    if result.video is None or result.drawn is None:
        return _NO_CAMERA
    from xneck.report.camera_section import camera_section  # needs OpenCV

    return camera_section(result.video, result.drawn, result.data)
