"""Figures for papers are those of the pages: drawn again they look the same, and their fonts are in the files."""

import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tests.command import run
from xneck.export.figure_files import page_panels, write_figure_files
from xneck.export.svg_drawing import redrawn
from xneck.report import style
from xneck.report.figure_block import FigureBlock, LegendEntry
from xneck.report.svg import svg_panel
from xneck.report.template import render
from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import write_text


def panel(shift: float = 0.0) -> Figure:
    """Lines of all styles, a band, a span, dots and words, with a label on its side."""
    x = np.linspace(0, 4, 300)
    figure, above, below = style.two_row_panel()
    style.span(above, "span", 1.0, 1.5, style.GAP, 0.6)
    for k, dashes in enumerate(style.DASHES):
        style.line(above, dashes, x, np.sin(x + k + shift), style.cable_colour(k), dashes)
    style.band(below, "band", x, -0.2 + 0 * x, 0.2 + 0.1 * np.sin(3 * x), style.JOINTS[0], 0.3)
    style.dots(below, "dots", x[::5], 0.1 * np.cos(5 * x[::5]), style.JOINTS[1], size=3.0, opacity=0.6)
    above.set_title("joint 1 & <2>", color=style.JOINTS[2])
    below.set_ylabel("error, µm")
    below.set_xlabel("time, s")
    return figure


def pixels(figure: Figure) -> np.ndarray:
    canvas = FigureCanvasAgg(figure)
    figure.set_facecolor("white")
    canvas.draw()
    return np.asarray(canvas.buffer_rgba(), dtype=float)[..., :3] / 255


def test_a_panel_that_is_drawn_again_looks_the_same() -> None:
    with style.drawing():
        drawn = panel()
        drawn.set_dpi(100)
        original = pixels(drawn)
        again = redrawn([str(svg_panel(panel(), "p", "a panel").svg)])
        again.set_dpi(100)
        other = panel(shift=0.3)
        other.set_dpi(100)
        differs, differs_more = (float(np.abs(pixels(f) - original).mean()) for f in (again, other))
    # coordinates are rounded to a hundredth of a point, and dots are drawn otherwise
    assert differs < 0.004
    assert differs_more > 3 * differs


def test_panels_one_under_another_look_as_each_alone() -> None:
    """Words and marks of each at its own place."""
    with style.drawing():
        svgs = [str(svg_panel(panel(shift), f"p{shift}", "a panel").svg) for shift in (0.0, 0.3)]
        figures = [redrawn(svgs), *(redrawn([svg]) for svg in svgs)]
        for figure in figures:
            figure.set_dpi(100)
        both, above, below = (pixels(figure) for figure in figures)
    assert len(both) == len(above) + len(below)
    assert np.abs(both[: len(above)] - above).mean() < 1e-3
    assert np.abs(both[len(above) :] - below).mean() < 1e-3
    assert np.abs(above - below).mean() > 3e-3


@pytest.fixture
def pages(tmp_path: Path) -> Path:
    """A folder with a page of two panels and a legend, as xneck writes it."""
    with style.drawing():
        panels = tuple(svg_panel(panel(k), f"p{k}", f"panel {k} & more") for k in range(2))
    block = FigureBlock(
        "A figure", "What to see.", panels, (LegendEntry("state", "#222222"), LegendEntry("dot", "#000000", "dot"))
    )
    template = tmp_path / "page.html.jinja"
    template.write_text('{% import "parts.html.jinja" as parts %}{{ parts.block(block) }}')
    folder = tmp_path / "results" / "monday"
    folder.mkdir(parents=True)
    write_text(folder / "report.html", render(template, block=block))
    return tmp_path / "results"


def test_every_panel_becomes_a_pdf_with_its_fonts(pages: Path, tmp_path: Path) -> None:
    files = write_figure_files(pages, tmp_path / "figures")
    assert [file["panel"] for file in files] == ["panel 0 & more", "panel 1 & more"]
    assert {(file["figure"], file["caption"], file["page"]) for file in files} == {
        ("A figure", "What to see.", "monday/report.html")
    }
    for file in files:
        content = (tmp_path / "figures" / file["file"]).read_bytes()
        assert content.startswith(b"%PDF")
        assert b"/FontFile2" in content
        assert b"/Type3" not in content


def test_the_same_page_gives_the_same_bytes(pages: Path, tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    names = [file["file"] for file in write_figure_files(pages, first)]
    write_figure_files(pages, second)
    assert all((first / name).read_bytes() == (second / name).read_bytes() for name in names)


def test_a_legend_comes_along(pages: Path) -> None:
    found = page_panels(pages / "monday/report.html")[0]
    assert [words for _, words in found.legend] == ["state", "dot"]
    figure = redrawn([found.svg], found.legend)
    assert {"state", "dot"} <= {text.get_text() for text in figure.axes[0].texts}


def test_an_edited_page_is_refused(pages: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    page = pages / "monday/report.html"
    page.write_text(re.sub("panel 0", "panel x", page.read_text()))
    with pytest.raises(Refused, match="not as xneck wrote it"):
        page_panels(page)
    ran = run(capfd, "export", pages, "--figures", tmp_path / "figures")
    assert (ran.status, len(ran.err.splitlines())) == (1, 1)
