"""The figures of a page as numbers, in a file beside it."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from xneck.report.block import Block
from xneck.report.drawn import Mark
from xneck_foundation.whole_file import write_text

SUFFIX = ".figures.json"
_DIGITS = 7


def figures_beside(page: Path) -> Path:
    """Where the figures of `page` are: report.figures.json beside report.html."""
    return page.with_suffix(SUFFIX)


def write_figures(blocks: Iterable[Block | None], page: Path) -> None:
    """All figures of `page`, whole or not at all; those that a page goes without are None."""
    figures = [_figure(block) for block in blocks if block is not None]
    write_text(figures_beside(page), json.dumps({"figures": figures}, ensure_ascii=False, separators=(",", ":")) + "\n")


def _figure(block: Block) -> dict[str, Any]:
    panels = [
        {
            "panel": panel.says,
            "axes": [
                {"title": s.title, "x": s.x, "y": s.y, "marks": [_mark(mark) for mark in s.marks]}
                for s in panel.storeys
            ],
        }
        for panel in block.panels
    ]
    return {"title": block.title, "caption": block.caption, "panels": panels}


def _mark(mark: Mark) -> dict[str, Any]:
    return {"name": mark.name, "kind": mark.kind} | {key: _plain(column) for key, column in mark.columns.items()}


def _plain(values: Any) -> Any:
    """Seven digits; what is not known is null."""
    if isinstance(values, tuple):
        return list(values)
    if np.ndim(values):
        return [_plain(value) for value in values]
    return float(f"{values:.{_DIGITS}g}") if np.isfinite(values) else None
