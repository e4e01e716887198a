"""The page itself: figures and tables of a result put into the template."""

from collections.abc import Mapping
from pathlib import Path

from identification.fasquelle.method import WELL_IDENTIFIED
from identification.fasquelle.reconstruction import Reconstruction, reconstruct
from identification.identifiability import durbin_wu_hausman
from mechanism.elasticity import MODELS
from synchronisation.check.explained_elongation import explain
from xneck.recording.pipeline import Result
from xneck.report import (
    cable_figures,
    camera_figures,
    fasquelle_figures,
    motion_figures,
    published,
    simulation_figures,
    tables,
    verdict,
)
from xneck.report.alignment import align
from xneck.report.block import Block
from xneck.report.figures_file import write_figures
from xneck.report.shots import shots
from xneck.report.style import drawing
from xneck.report.template import render
from xneck.report.went_in import input_rows, version_text
from xneck.report.wording import number
from xneck_foundation.whole_file import write_text


def write_report(result: Result, path: Path) -> None:
    """One recording's report with its figures' numbers beside it, whole or not at all; the same result gives the same bytes."""
    found = reconstruct(result.data, result.identification)
    figures = _figures(result, found)
    write_figures(figures.values(), path)
    write_text(path, page(result, found, figures))


def page(result: Result, found: Reconstruction, figures: Mapping[str, Block | None]) -> str:
    """The HTML of a result, with everything that it shows inside."""
    return render(
        "report.html.jinja",
        result=result,
        data=result.data,
        sentence=verdict.sentence(result),
        head=verdict.figures(result),
        tables=tables,
        inputs=input_rows(result.data.provenance),
        versions=version_text(result.data.provenance),
        table_1=tables.fasquelle_table(
            "Table 1: friction, from the arm equations",
            [result.identification.dry_and_viscous, result.identification.dry_only],
            published.TABLE_1,
            result.data.neck.M,
        ),
        table_2=tables.fasquelle_table(
            "Table 2: friction and elasticity",
            [result.identification.elastic[m] for m in MODELS],
            published.TABLE_2,
            result.data.neck.M,
        ),
        mean_errors=[(m, result.identification.mean_error(m)) for m in MODELS],
        hausman=durbin_wu_hausman(result.estimates.solution)[1],
        published=published,
        number=number,
        well_identified=WELL_IDENTIFIED,
        shots=shots(result),
        couple_errors=fasquelle_figures.couple_errors(found),
        **figures,
    )


def _figures(result: Result, found: Reconstruction) -> dict[str, Block | None]:
    data = result.data
    alignment, elongation = align(data), explain(data.arm, data.state)
    with drawing():
        return {
            "calibration_figure": camera_figures.coverage_and_errors(result.calibration)
            if result.calibration
            else None,
            "alpha_figure": motion_figures.alpha_over_time(data),
            "travel_figure": motion_figures.travel_on_both_clocks(data, alignment),
            "clock_figure": motion_figures.clock_evidence(data, alignment),
            "elongation_figure": cable_figures.elongation_over_time(data, elongation),
            "force_figure": cable_figures.elongation_against_force(data, elongation),
            "couple_figure": fasquelle_figures.couples(found),
            "tension_figure": fasquelle_figures.tensions(found),
            "error_figure": fasquelle_figures.tension_errors(found),
            "simulation_figure": (
                simulation_figures.simulated_beside_measured(result.simulated) if result.simulated else None
            ),
        }
