"""How Rerun lays a recording out: the picture on the left, the curves under each other on the right."""

from collections.abc import Mapping
from typing import Any

from identification.dataset.series import Series
from xneck.viewers.rerun_picture import VIDEO

TIMELINE = "time"
"""s on the log's clock"""
_VIEWS = (
    ("joint angles alpha, rad: state with its band of 2 sigma, frames", ("state", "alpha"), ("state_band", "alpha", "_low"),
     ("state_band", "alpha", "_high"), ("angles", "alpha")),
    ("frames less the state, rad, and the state's own band of 2 sigma", ("away", "alpha"), ("away", "alpha", "_low"),
     ("away", "alpha", "_high")),
    ("elongations of the cables x, m", ("state", "x")),
    ("forces of the motors f, N", ("state", "f")),
    ("lengths of the cables by the pulley model, m", ("model", "length")),
    ("simulated alpha beside the state, rad", ("simulated", "alpha"), ("state", "alpha")),
    ("motor angles theta, simulated beside measured, rad", ("simulated", "theta"), ("state", "theta")),
    ("simulated tensions of the cables, N", ("simulated", "tension")),
)  # fmt: skip
_ABOVE = 4
"""views that are seen at once; the others are tabs below"""
_TALL = 1.2
"""of the first two against the others"""


def blueprint(rr: Any, shown: Mapping[str, Series], picture: bool) -> Any:
    """The layout for what is shown, by topic."""
    rrb = rr.blueprint
    views = []
    for title, *parts in _VIEWS:
        contents = [
            f"/{topic}/{stem}{k + 1}{''.join(suffix)}"
            for topic, stem, *suffix in parts
            if topic in shown
            for k in range(shown[topic].matrix(stem, *suffix).shape[1])
        ]
        if contents:
            legend = rrb.PlotLegend(visible=parts[0][0] != "away")  # its joints have the colours of the view above
            views.append(rrb.TimeSeriesView(origin="/", contents=contents, name=title, plot_legend=legend))
    rows = [*views[:_ABOVE], *([rrb.Tabs(*views[_ABOVE:])] if views[_ABOVE:] else [])]
    curves = rrb.Vertical(*rows, row_shares=[_TALL if k < 2 else 1.0 for k in range(len(rows))])
    whole = curves
    if picture:
        whole = rrb.Horizontal(rrb.Spatial2DView(origin=f"/{VIDEO}", name="video"), curves, column_shares=[1, 1])
    return rrb.Blueprint(whole, rrb.TimePanel(timeline=TIMELINE, state="collapsed"), collapse_panels=True)
