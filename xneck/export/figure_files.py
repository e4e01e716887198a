"""The figures of pages that xneck wrote, each panel as a PDF for a paper: vectors, with its fonts in it."""

import html
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib

from xneck.export.svg_drawing import redrawn
from xneck.report.style import drawing
from xneck_foundation.authorship import written_by_xneck
from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import check_output, whole_file

_FIGURE = re.compile(r"<figure>\s*<figcaption>(.*?)</figcaption>(.*?)</figure>", re.DOTALL)
_PANEL = re.compile(r'<svg class="plot".*?</svg>', re.DOTALL)
_ENTRY = re.compile(r"<li>(<svg.*?</svg>)(.*?)</li>", re.DOTALL)
_TITLE, _CAPTION = re.compile(r"<h3>(.*?)</h3>", re.DOTALL), re.compile(r"<p>(.*?)</p>", re.DOTALL)
_LABEL = re.compile(r'aria-label="([^"]*)"')
_PDF = {"pdf.fonttype": 42}
"""fonts as TrueType, which publishers ask for"""
_MAX_NAME = 60
"""characters of a file's name that come from the panel's words"""


@dataclass(frozen=True)
class PagePanel:
    """A panel of a page."""

    figure: str
    """title of the figure that it belongs to"""
    caption: str
    words: str
    """what it shows, as those hear who do not see it"""
    svg: str
    legend: tuple[tuple[str, str], ...]
    """of its figure: swatch (SVG) and words"""


def page_panels(page: Path) -> list[PagePanel]:
    """All panels of a page, in its order. Raises Refused where the page is not as xneck wrote it."""
    if not written_by_xneck(page):
        raise Refused(page, "is not as xneck wrote it", "make the page anew")
    return list(_panels(page.read_text(encoding="utf-8")))


def _panels(text: str) -> Iterator[PagePanel]:
    for caption, body in _FIGURE.findall(text):
        title, words = (found[1] if (found := part.search(caption)) else "" for part in (_TITLE, _CAPTION))
        legend = tuple((swatch, _plain(entry)) for swatch, entry in _ENTRY.findall(caption))
        for svg in _PANEL.findall(body):
            label = _LABEL.search(svg)
            yield PagePanel(_plain(title), _plain(words), _plain(label[1] if label else title), svg, legend)


def _plain(text: str) -> str:
    return html.unescape(re.sub(r"<[^>]+>", "", text)).strip()


def write_figure_files(folder: Path, out: Path) -> list[dict[str, Any]]:
    """Writes every panel of the pages in a folder of results, and returns the files with what they show, ready for JSON.

    Raises Refused where there are no pages, one is not as xneck wrote it, or a file is in the way.
    """
    pages = sorted(folder.rglob("*.html"))
    figures = [(page, panel) for page in pages for panel in page_panels(page)]
    if not figures:
        raise Refused(folder, "holds no pages with figures", "give a folder of `xneck run` or `xneck diagnose`")
    out.mkdir(parents=True, exist_ok=True)
    names = [_name(folder, page, number, panel) for number, (page, panel) in enumerate(figures, start=1)]
    for name in names:
        check_output(out / name)
    with drawing(), matplotlib.rc_context(_PDF):  # type: ignore[arg-type]
        for name, (_, panel) in zip(names, figures, strict=True):
            figure = redrawn([panel.svg], panel.legend)
            with whole_file(out / name) as part:
                figure.savefig(part, format="pdf", metadata={"Title": panel.words, "CreationDate": None})
    return [
        {
            "file": name,
            "page": page.relative_to(folder).as_posix(),
            "figure": panel.figure,
            "panel": panel.words,
            "caption": panel.caption,
        }
        for name, (page, panel) in zip(names, figures, strict=True)
    ]


def _name(folder: Path, page: Path, number: int, panel: PagePanel) -> str:
    """Such as monday-report-03-alpha-of-joint-2-over-time.pdf."""
    place = "-".join(page.relative_to(folder).with_suffix("").parts)
    words = re.sub(r"[^a-z0-9]+", "-", panel.words.lower()).strip("-")[:_MAX_NAME].rstrip("-")
    return f"{place}-{number:02d}-{words}.pdf"
