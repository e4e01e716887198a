"""Axes that record by name what is plotted into them, so that a page can hold every figure as numbers too."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

MarkKind = Literal["line", "dots", "band", "span", "arrows", "circles", "outline", "shades"]
"""a mark's columns: lines, dots and outlines have x, y (NaN is a gap); bands x, low, high; spans low, high along one axis;
arrows x, y, dx, dy; circles x, y, radius; shades x, y and a row of values for each y"""


@dataclass(frozen=True)
class PlottedMark:
    """One line, band or the like that was plotted, in the units of the axes' labels; a column of texts names values of an axis."""

    name: str
    kind: MarkKind
    columns: dict[str, NDArray[np.float64] | tuple[str, ...]]


class RecordedAxes(Axes):
    """Axes of matplotlib with a record of their marks."""

    def __init__(self, figure: Figure, place: tuple[float, float, float, float]) -> None:
        super().__init__(figure, place)
        self.marks: list[PlottedMark] = []
        figure.add_axes(self)

    def record(self, name: str, kind: MarkKind, **columns: ArrayLike | Sequence[str]) -> None:
        """Records a mark; to be called where it is plotted."""
        texts = {key: tuple(map(str, c)) for key, c in columns.items() if isinstance(c, tuple)}
        numbers = {key: np.asarray(c, dtype=float) for key, c in columns.items() if key not in texts}
        self.marks.append(PlottedMark(name, kind, numbers | texts))


@dataclass(frozen=True)
class AxesRecord:
    """Title, labels and marks of one axes of a panel."""

    title: str
    x: str
    y: str
    marks: tuple[PlottedMark, ...]


def axes_records(figure: Figure) -> tuple[AxesRecord, ...]:
    """The record of every axes of a figure, from the top down."""
    axes = sorted((a for a in figure.axes if isinstance(a, RecordedAxes)), key=lambda a: -a.get_position().y0)
    return tuple(AxesRecord(a.get_title(loc="left"), a.get_xlabel(), a.get_ylabel(), tuple(a.marks)) for a in axes)
