"""The one visual language of all figures: colours, fonts, sizes, and the few marks that they are drawn with.

Colours tell apart under every colour blindness and in grey print: Okabe and Ito's for cables, Tol's muted for joints,
Tol's high-contrast for models. What was measured is near black, whatever it is.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from xneck.report.recorded_axes import RecordedAxes

Array = NDArray[np.float64]

CABLES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C6D1F", "#5D5D5D")
JOINTS = ("#332288", "#117733", "#882255", "#AA4499", "#44AA99", "#999933", "#CC6677", "#6699CC")
MEASURED = "#222222"
UNDERLAY = "#B8B8B8"
"""colour of measured values under a model: a broad pale line that stays visible under a thin one"""
UNDERLAY_WIDTH = 3.0
GAP = "#E8B4B8"
MUTED = "#8A8A8A"
MODELS = {1: "#004488", 2: "#B8860B", 3: "#BB5566"}
FRICTION = {"none": "#BB5566", "dry": "#004488", "viscous": "#E0A91B"}
DASHES = {"solid": "", "dashed": "6 3", "dotted": "1.5 2.5"}
"""line styles and their SVG patterns, so that the page's legends show what matplotlib draws"""

WIDTH = 4.6
"""in: narrow enough that a phone shows a panel's 8.5 pt labels at about their size"""
_LEFT, _RIGHT, _BOTTOM, _TOP = 0.68, 0.12, 0.46, 0.30
"""in: margins"""
LOG_TIME = "time on the log's clock, s"
"""label of the axis along which a page's cursor runs"""
MAX_POINTS = 1200
"""in a line: more than the pixels that it is drawn on"""
MAX_DOTS = 1000
"""in one set of dots"""

_RC = {
    "svg.fonttype": "none",
    "svg.hashsalt": "xneck",
    "path.simplify": False,  # would drop the dots, which are lines without length
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Helvetica", "Arial", "sans-serif"],
    "font.size": 8.5,
    "axes.titlesize": 9.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.edgecolor": "#606060",
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.formatter.useoffset": False,
    "axes.xmargin": 0.01,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.6,
    "xtick.color": "#404040",
    "ytick.color": "#404040",
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "lines.linewidth": 1.1,
}  # fmt: skip


@contextmanager
def drawing() -> Iterator[None]:
    """Within this block matplotlib has the settings of our figures; they are made and written inside it."""
    with matplotlib.rc_context(_RC):  # type: ignore[arg-type]
        yield


def cable_colour(j: int) -> str:
    """Colour of cable j, from 0."""
    return CABLES[j % len(CABLES)]


def joint_colour(i: int) -> str:
    """Colour of joint i, from 0."""
    return JOINTS[i % len(JOINTS)]


def one_row_panel(height: float = 2.5) -> tuple[Figure, RecordedAxes]:
    """One panel; margins in inches are the same for all, so that axes stand under each other."""
    figure = Figure(figsize=(WIDTH, height))
    return figure, _axes(figure, _BOTTOM, height - _TOP)


def two_row_panel(height: float = 3.4, lower: float = 1.0) -> tuple[Figure, RecordedAxes, RecordedAxes]:
    """A panel with a second, lower one (`lower` in inches) on the same horizontal axis."""
    figure = Figure(figsize=(WIDTH, height))
    below = _axes(figure, _BOTTOM, _BOTTOM + lower)
    above = _axes(figure, _BOTTOM + lower + 0.14, height - _TOP)
    above.sharex(below)
    above.tick_params(labelbottom=False, bottom=False)
    return figure, above, below


def _axes(figure: Figure, low: float, high: float) -> RecordedAxes:
    """Axes from `low` to `high`, in; the vertical label at a fixed place, where no tick's number pushes it out."""
    height = float(figure.get_figheight())
    inner = WIDTH - _LEFT - _RIGHT
    axes = RecordedAxes(figure, (_LEFT / WIDTH, low / height, inner / WIDTH, (high - low) / height))
    axes.yaxis.set_label_coords((0.16 - _LEFT) / inner, 0.5)
    axes.locator_params(axis="y", nbins=7 if high - low > 1.2 else 5)
    return axes


def line(
    axes: RecordedAxes,
    name: str,
    x: Array,
    y: Array,
    colour: str,
    style: str = "solid",
    width: float = 1.1,
    thin: bool = True,
) -> None:
    """A line of at most POINTS points that keeps every peak, unless it was thinned before; a gap is not a number."""
    if thin:
        x, y = decimated(x, y)
    dashes = [float(part) / width for part in DASHES[style].split()]
    (drawn,) = axes.plot(x, y, color=colour, linewidth=width)
    if dashes:
        drawn.set_dashes(dashes)
    axes.record(name, "line", x=x, y=y)


def dots(
    axes: RecordedAxes,
    name: str,
    x: Array,
    y: Array,
    colour: str,
    size: float = 2.2,
    opacity: float = 1.0,
    reach: float = np.inf,
) -> None:
    """Dots of `size` points, thinned to DOTS: one path of lines without length and round ends, a tenth of markers' bytes.

    Those beyond +-reach are drawn there.
    """
    step = -(-len(x) // MAX_DOTS) or 1
    x, y = x[::step], y[::step]
    kept = np.isfinite(x) & np.isfinite(y)
    gap = np.full(int(kept.sum()), np.nan)
    xs, ys = (np.column_stack([v[kept], v[kept], gap]).ravel() for v in (x, np.clip(y, -reach, reach)))
    axes.plot(xs, ys, color=colour, linewidth=size, solid_capstyle="round", alpha=opacity)
    axes.record(name, "dots", x=x[kept], y=y[kept])


def band(axes: RecordedAxes, name: str, x: Array, low: Array, high: Array, colour: str, opacity: float = 0.35) -> None:
    """Fills the area between two curves."""
    axes.fill_between(x, low, high, color=colour, alpha=opacity, linewidth=0)
    axes.record(name, "band", x=x, low=low, high=high)


def span(
    axes: RecordedAxes, name: str, low: float, high: float, colour: str, opacity: float, flat: bool = False
) -> None:
    """Fills the stretch between two values of x, or of y where it is `flat`."""
    (axes.axhspan if flat else axes.axvspan)(low, high, color=colour, alpha=opacity, linewidth=0)
    axes.record(name, "span", low=low, high=high)


def decimated(x: Array, y: Array, points: int = MAX_POINTS) -> tuple[Array, Array]:
    """At most `points` of a curve: the lowest and the highest of every stretch, in their order."""
    if len(x) <= points:
        return x, y
    edges = np.linspace(0, len(x), points // 2 + 1).astype(int)
    safe = np.where(np.isfinite(y), y, 0.0)
    keep = {0, len(x) - 1}
    for start, end in pairwise(edges.tolist()):
        keep |= {start + int(np.argmin(safe[start:end])), start + int(np.argmax(safe[start:end]))}
    index = np.array(sorted(keep))
    return x[index], y[index]
