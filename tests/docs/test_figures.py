"""Figures in pages are those of the records and of the catalogue, and no other figure passes for one."""

import re
from pathlib import Path

import pytest

from benchmarks.figures.__main__ import all_figures
from benchmarks.figures.pages import ROOT, filled, pages, without_figures
from tests.docs.pages import PAGES

FIGURE = re.compile(
    r"(?<![\w.])\d[\d.]*(?:e-?\d+)?(?: (?:to|of|in) [\d.]+)? ?(?:%|(?:deg|ms|mm|px|rad|ppm|MB|times)\b)|\b\d+ of \d+\b"
)
"""a number with the unit of an error, a rate or a cost; seconds, minutes and hertz say what was done"""
HELD = re.compile(r"`(tests/[\w/.]+)`|\]\((thresholds\.md)\)")
"""what holds a bound that is no measured figure"""


@pytest.fixture(scope="module")
def figures() -> dict[str, str]:
    return all_figures()


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_says_what_the_records_say(page: Path, figures: dict[str, str]) -> None:
    """Where this fails, `python -m benchmarks.figures` writes the page anew."""
    text = page.read_text(encoding="utf-8")
    assert text == filled(text, figures)


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_a_figure_does_not_begin_a_line(page: Path) -> None:
    """Markdown would take such a line for HTML; a figure that is a table or a list stands between lines of its own."""
    for line in page.read_text(encoding="utf-8").splitlines():
        assert not re.match(r"[-*\s]*<!--figure [^>]*-->.*\S", line), line


def typed_figures(text: str) -> list[str]:
    """Figures outside placeholders, in paragraphs and rows that name nothing that holds them."""
    parts = re.split(r"\n\s*\n|\n(?=\s*(?:- |\|))", without_figures(text))
    return [found[0] for part in parts if not HELD.search(part) for found in FIGURE.finditer(part)]


def test_the_page_on_accuracy_has_no_typed_figure() -> None:
    page = PAGES["accuracy.md"]
    assert typed_figures(page) == []
    assert all((ROOT / path).exists() for path, _ in HELD.findall(page) if path)


@pytest.mark.parametrize(
    "typed", ["errs by 0.05 deg rms", "named in 203 of 209", "within 10 %", "- 1.0 to 1.1 times the bound", "1e-5 rad"]
)
def test_a_typed_figure_is_noticed(typed: str) -> None:
    assert len(typed_figures(f"Words.\n\n{typed}\n")) == 1
    assert typed_figures(f"{typed} (`tests/docs`)") == []
    assert typed_figures(f"<!--figure a.b-->{typed}<!--/-->") == []


def test_the_readme_has_no_typed_figure() -> None:
    assert typed_figures(PAGES["README.md"].replace("95 % interval", "interval")) == []
