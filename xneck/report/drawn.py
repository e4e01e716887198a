"""Axes that remember by name what is drawn into them, so that every figure is there as numbers too."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

Kind = Literal["line", "dots", "band", "span", "arrows", "circles", "outline", "shades"]
"""what columns a mark has: x, y of lines, dots and outlines (a gap is not a number), x, low, high of bands, low, high of
spans along one axis, x, y, dx, dy of arrows, x, y, radius of circles; shades have x, y and a row of values for each y"""


@dataclass(frozen=True)
class Mark:
    """One thing that was drawn, in the units of the axes' labels; texts are names along an axis."""

    name: str
    kind: Kind
    columns: dict[str, NDArray[np.float64] | tuple[str, ...]]


class DrawnAxes(Axes):
    """matplotlib's, with the marks that the figures' functions noted."""

    def __init__(self, figure: Figure, place: tuple[float, float, float, float]) -> None:
        super().__init__(figure, place)
        self.marks: list[Mark] = []
        figure.add_axes(self)

    def note(self, name: str, kind: Kind, **columns: ArrayLike | Sequence[str]) -> None:
        """To be called where a mark is drawn."""
        texts = {key: tuple(map(str, c)) for key, c in columns.items() if isinstance(c, tuple)}
        numbers = {key: np.asarray(c, dtype=float) for key, c in columns.items() if key not in texts}
        self.marks.append(Mark(name, kind, numbers | texts))


@dataclass(frozen=True)
class Storey:
    """What one axes of a panel holds."""

    title: str
    x: str
    y: str
    marks: tuple[Mark, ...]


def storeys(figure: Figure) -> tuple[Storey, ...]:
    """Of every axes of a figure, from above."""
    found = sorted((a for a in figure.axes if isinstance(a, DrawnAxes)), key=lambda a: -a.get_position().y0)
    return tuple(Storey(a.get_title(loc="left"), a.get_xlabel(), a.get_ylabel(), tuple(a.marks)) for a in found)
