"""How Rerun lays a recording out: the picture on the left, the curves under each other on the right."""

from collections.abc import Mapping
from typing import Any

from identification.dataset.series import Series

TIMELINE = "time"
"""s on the log's clock"""
VIDEO_ENTITY = "video"
"""the video, with the lines drawn over it below"""
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
_STACKED_VIEWS = 4
"""views under each other; the others are tabs below"""
_TALL_SHARE = 1.2
"""height of each of the first two views; that of another is 1"""


def blueprint(rr: Any, curves: Mapping[str, Series], video: bool) -> Any:
    """The layout for these curves, by topic, with a view of the video if there is one."""
    rrb = rr.blueprint
    views = []
    for title, *parts in _VIEWS:
        contents = [
            f"/{topic}/{stem}{k + 1}{''.join(suffix)}"
            for topic, stem, *suffix in parts
            if topic in curves
            for k in range(curves[topic].matrix(stem, *suffix).shape[1])
        ]
        if contents:
            legend = rrb.PlotLegend(visible=parts[0][0] != "away")  # its joints have the colours of the view above
            views.append(rrb.TimeSeriesView(origin="/", contents=contents, name=title, plot_legend=legend))
    rows = [*views[:_STACKED_VIEWS], *([rrb.Tabs(*views[_STACKED_VIEWS:])] if views[_STACKED_VIEWS:] else [])]
    column = rrb.Vertical(*rows, row_shares=[_TALL_SHARE if k < 2 else 1.0 for k in range(len(rows))])
    layout = column
    if video:
        layout = rrb.Horizontal(
            rrb.Spatial2DView(origin=f"/{VIDEO_ENTITY}", name="video"), column, column_shares=[1, 1]
        )
    return rrb.Blueprint(layout, rrb.TimePanel(timeline=TIMELINE, state="collapsed"), collapse_panels=True)
