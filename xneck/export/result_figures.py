"""Figures of results that are in memory, as matplotlib figures: those that the pages show."""

from collections.abc import Callable
from functools import singledispatch
from pathlib import Path
from typing import Any, TypeVar

import matplotlib
from matplotlib.figure import Figure

from diagnosis.diagnose import Diagnosis
from identification.dataset.dataset import DataSet
from identification.simulation.simulated_motion import SimulatedMotion
from identification.simulation.simulated_recording import SimulatedRecording
from synchronisation.check.explained_elongation import explain
from xneck.export.svg_drawing import redrawn
from xneck.report import cable_figures, motion_figures, simulation_figures
from xneck.report.clock_alignment import clock_alignment
from xneck.report.diagnosis_page import diagnosis_figures
from xneck.report.figure_block import FigureBlock
from xneck.report.style import drawing
from xneck_foundation.authorship import MARK
from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import whole_file

Result = TypeVar("Result")
_EMBEDDED_FONTS = {"pdf.fonttype": 42}
"""TrueType, which publishers ask for"""


def figures(result: object) -> dict[str, Figure]:
    """The figures of a data set, a simulation or a diagnosis, by their titles, to look at, change and save.

    Raises Refused where there are none of such a result.

    >>> import xneck
    >>> drawn = xneck.figures(xneck.read_dataset("tuesday.mcap"))
    >>> list(drawn)[:2]
    ['Angles of the joints', 'Cable travel on one clock']
    >>> drawn["Angles of the joints"].savefig("angles.pdf")
    """
    with drawing():
        return {block.title: _drawn(block) for block in _blocks(result)}


def write_picture(block: Callable[[Result], FigureBlock], result: Result, path: Path) -> None:
    """Writes one figure of a result, whole or not at all, as .svg, .pdf or .png."""
    kind = path.suffix.removeprefix(".").lower()
    metadata = {"png": {"Software": MARK}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    with drawing(), matplotlib.rc_context(_EMBEDDED_FONTS), whole_file(path) as part:  # type: ignore[arg-type]
        _drawn(block(result)).savefig(part, format=kind, metadata=metadata, facecolor="white", dpi=200)


def _drawn(block: FigureBlock) -> Figure:
    return redrawn([panel.svg for panel in block.panels], [(entry.swatch, entry.label) for entry in block.legend])


@singledispatch
def _blocks(result: Any) -> list[FigureBlock]:
    raise Refused(
        "figures", f"there are none of {type(result).__name__}", "give a data set, a simulation or a diagnosis"
    )


@_blocks.register
def _(result: DataSet) -> list[FigureBlock]:
    alignment, elongation = clock_alignment(result), explain(result.arm, result.state)
    return [
        motion_figures.alpha_over_time(result),
        motion_figures.travel_on_both_clocks(result, alignment),
        motion_figures.clock_evidence(result, alignment),
        cable_figures.elongation_over_time(result, elongation),
        cable_figures.elongation_against_force(result, elongation),
    ]


@_blocks.register
def _(result: SimulatedRecording) -> list[FigureBlock]:
    return [simulation_figures.simulated_beside_measured(result)]


@_blocks.register
def _(result: SimulatedMotion) -> list[FigureBlock]:
    return [simulation_figures.simulated_beside_designed(result)]


@_blocks.register
def _(result: Diagnosis) -> list[FigureBlock]:
    return [block for block in diagnosis_figures(result).all if block is not None]
