"""The page itself: figures and tables of a result put into the template."""

import base64
from importlib.resources import files
from pathlib import Path

import cv2
import numpy as np
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from numpy.typing import NDArray

from identification.reconstruction import reconstruct
from identification.seed_method import WELL_IDENTIFIED
from mechanism.elasticity import MODELS
from vision.pipeline import Result
from vision.report import (
    cable_figures,
    camera_figures,
    motion_figures,
    published,
    seed_figures,
    simulation_figures,
    tables,
    verdict,
)
from vision.report.alignment import align
from vision.report.elongation import explain
from vision.report.style import drawing
from vision.report.wording import number
from xneck.whole_file import write_text

PICTURE_WIDTH = 960
"""px: of an annotated frame in the page"""
_JPEG_QUALITY = 82


def write_report(result: Result, path: Path) -> None:
    """One recording's report, whole or not at all; the same result gives the same bytes."""
    write_text(path, page(result))


def page(result: Result) -> str:
    """The HTML of a result, with everything that it shows inside."""
    home = files("vision.report")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(home.joinpath("report.html.jinja").read_text(encoding="utf-8"))
    return template.render(
        result=result,
        data=result.data,
        style_sheet=Markup(home.joinpath("report.css").read_text(encoding="utf-8")),  # our own file, not a person's
        sentence=verdict.sentence(result),
        head=verdict.figures(result),
        tables=tables,
        table_1=tables.seed_table(
            "Table 1: friction, from the arm equations",
            [result.identification.dry_and_viscous, result.identification.dry_only],
            published.TABLE_1,
            result.data.neck.M,
        ),
        table_2=tables.seed_table(
            "Table 2: friction and elasticity",
            [result.identification.elastic[m] for m in MODELS],
            published.TABLE_2,
            result.data.neck.M,
        ),
        mean_errors=[(m, result.identification.mean_error(m)) for m in MODELS],
        published=published,
        number=number,
        well_identified=WELL_IDENTIFIED,
        pictures=[_shown(result, index, picture) for index, picture in result.pictures],
        **_figures(result),
    )


def _figures(result: Result) -> dict[str, object]:
    data = result.data
    found = reconstruct(data, result.identification)
    alignment, elongation = align(data), explain(data)
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
            "couple_figure": seed_figures.couples(found),
            "couple_errors": seed_figures.couple_errors(found),
            "tension_figure": seed_figures.tensions(found),
            "error_figure": seed_figures.tension_errors(found),
            "simulation_figure": (
                simulation_figures.simulated_beside_measured(result.simulated) if result.simulated else None
            ),
        }


def _shown(result: Result, index: int, picture: NDArray[np.uint8]) -> tuple[int, float, str]:
    """Frame index, its camera time in s, and the picture as a data URI."""
    height, width = picture.shape[:2]
    if width > PICTURE_WIDTH:
        size = (PICTURE_WIDTH, round(height * PICTURE_WIDTH / width))
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    done, packed = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    assert done
    uri = "data:image/jpeg;base64," + base64.b64encode(packed.tobytes()).decode("ascii")
    return index, float(result.angles.time[index]), uri
