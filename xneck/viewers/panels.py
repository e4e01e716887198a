"""Which columns of a data set are shown together, the same in every viewer."""

from collections.abc import Mapping
from dataclasses import dataclass

from identification.dataset.series import Series

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C6D1F", "#7D7D7D")
"""of joints and of cables, by number: Okabe and Ito's, which are told apart on dark ground and on light"""


@dataclass(frozen=True)
class Curve:
    """A column of a series, which is the topic of the data set's file that it is in."""

    topic: str
    column: str
    colour: str
    dots: bool = False
    """single values rather than a course"""


@dataclass(frozen=True)
class Panel:
    """Curves over one time axis and one axis of values."""

    title: str
    curves: tuple[Curve, ...]


_PANELS = (
    ("alpha, rad", ("state", "alpha"), ("angles", "alpha")),
    ("sigma of alpha, rad", ("state", "sigma_alpha"), ("angles", "sigma")),
    ("motor angles theta, rad", ("state", "theta")),
    ("elongations x, m", ("state", "x")),
    ("motor forces f, N", ("state", "f")),
)
_DOTTED = "angles"


def colour(number: int) -> str:
    """Of joint or cable `number`, from 0."""
    return COLOURS[number % len(COLOURS)]


def panels(series: Mapping[str, Series]) -> tuple[Panel, ...]:
    """Panels of what is there: series by topic; a panel without a column is left out."""
    found = []
    for title, *parts in _PANELS:
        curves = [curve for topic, stem in parts if topic in series for curve in _numbered(series[topic], topic, stem)]
        if curves:
            found.append(Panel(title, tuple(curves)))
    return tuple(found)


def _numbered(series: Series, topic: str, stem: str) -> list[Curve]:
    return [Curve(topic, f"{stem}{k + 1}", colour(k), topic == _DOTTED) for k in range(series.matrix(stem).shape[1])]
