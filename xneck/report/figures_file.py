"""The figures of a page as numbers, in a file beside it."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from xneck.report.figure_block import FigureBlock
from xneck.report.recorded_axes import PlottedMark
from xneck_foundation.whole_file import write_text

SUFFIX = ".figures.json"
_DIGITS = 7


def figures_beside(page: Path) -> Path:
    """The file with the figures of `page`, such as report.figures.json beside report.html."""
    return page.with_suffix(SUFFIX)


def write_figures(blocks: Iterable[FigureBlock | None], page: Path) -> None:
    """Writes all figures of `page`, whole or not at all; a figure that the page goes without is None."""
    figures = [_figure_json(block) for block in blocks if block is not None]
    write_text(figures_beside(page), json.dumps({"figures": figures}, ensure_ascii=False, separators=(",", ":")) + "\n")


def _figure_json(block: FigureBlock) -> dict[str, Any]:
    panels = [
        {
            "panel": panel.description,
            "axes": [
                {"title": axes.title, "x": axes.x, "y": axes.y, "marks": [_mark_json(mark) for mark in axes.marks]}
                for axes in panel.axes
            ],
        }
        for panel in block.panels
    ]
    return {"title": block.title, "caption": block.caption, "panels": panels}


def _mark_json(mark: PlottedMark) -> dict[str, Any]:
    return {"name": mark.name, "kind": mark.kind} | {key: _column_json(column) for key, column in mark.columns.items()}


def _column_json(values: Any) -> Any:
    """A column ready for JSON: numbers to seven digits, null for NaN."""
    if isinstance(values, tuple):
        return list(values)
    if np.ndim(values):
        return [_column_json(value) for value in values]
    return float(f"{values:.{_DIGITS}g}") if np.isfinite(values) else None
