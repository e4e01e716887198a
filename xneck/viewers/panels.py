"""Which columns of a data set are plotted together, the same in every viewer."""

from collections.abc import Mapping
from dataclasses import dataclass

from identification.dataset.series import Series

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C6D1F", "#7D7D7D")
"""of joints and of cables, by number: Okabe and Ito's, which can be told apart on dark and on light ground"""


@dataclass(frozen=True)
class Curve:
    """A column of a series to plot; the topic is the series' name in the data set's file."""

    topic: str
    column: str
    colour: str
    dots: bool = False
    """drawn as single values rather than as a line"""


@dataclass(frozen=True)
class PlotPanel:
    """Curves in one plot over time."""

    title: str
    curves: tuple[Curve, ...]


_PANELS = (
    ("alpha, rad", ("state", "alpha"), ("angles", "alpha")),
    ("sigma of alpha, rad", ("state", "sigma_alpha"), ("angles", "sigma")),
    ("motor angles theta, rad", ("state", "theta")),
    ("elongations x, m", ("state", "x")),
    ("motor forces f, N", ("state", "f")),
)
_DOTTED_TOPIC = "angles"


def curve_colour(number: int) -> str:
    """Colour of the joint or cable `number`, from 0."""
    return COLOURS[number % len(COLOURS)]


def plot_panels(series: Mapping[str, Series]) -> tuple[PlotPanel, ...]:
    """The panels for these series, by topic; a panel without a curve is left out."""
    out = []
    for title, *parts in _PANELS:
        curves = [
            curve for topic, stem in parts if topic in series for curve in _numbered_curves(series[topic], topic, stem)
        ]
        if curves:
            out.append(PlotPanel(title, tuple(curves)))
    return tuple(out)


def _numbered_curves(series: Series, topic: str, stem: str) -> list[Curve]:
    return [
        Curve(topic, f"{stem}{k + 1}", curve_colour(k), topic == _DOTTED_TOPIC)
        for k in range(series.matrix(stem).shape[1])
    ]
