"""Placeholders in Markdown: `<!--figure study.named-->221 of 228<!--/-->`, whose text is written from the records.

A figure that is a table or a list begins and ends with a line break, so that it stands on lines of its own.
"""

import re
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]

PLACEHOLDER = re.compile(r"<!--figure ([a-z0-9_.]+)-->(.*?)<!--/-->", re.DOTALL)


class UnknownFigure(ValueError):
    """A page asks for a figure that no record gives."""


def pages() -> tuple[Path, ...]:
    """Every page that may hold figures."""
    return (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "benchmarks").glob("*.md")))


def filled(text: str, figures: Mapping[str, str]) -> str:
    """The page with the text of every placeholder as the figures say it.

    Raises UnknownFigure for a name that is not among the figures.
    """

    def written(found: re.Match[str]) -> str:
        name = found[1]
        if name not in figures:
            raise UnknownFigure(f"there is no figure {name}; there are {', '.join(sorted(figures))}")
        return f"<!--figure {name}-->{figures[name]}<!--/-->"

    return PLACEHOLDER.sub(written, text)


def without_figures(text: str) -> str:
    """The page with its placeholders and their texts taken out."""
    return PLACEHOLDER.sub("", text)
