"""How Rerun lays a recording out: the picture on the left, the curves under each other on the right."""

from collections.abc import Mapping
from typing import Any

from identification.series import Series
from vision.viewers.rerun_picture import VIDEO

_VIEWS = (
    ("joint angles alpha, rad: state with its band of 2 sigma, frames", ("state", "alpha"), ("band", "low"), ("band", "high"),
     ("angles", "alpha")),
    ("frames less the state, rad, and the band of 2 sigma", ("away", "alpha"), ("away", "low"), ("away", "high")),
    ("elongations of the cables x, m", ("state", "x")),
    ("forces of the motors f, N", ("state", "f")),
    ("lengths of the cables by the pulley model, m", ("model", "length")),
    ("angles of the motors theta, rad", ("state", "theta")),
    ("simulated: alpha, rad", ("simulated", "alpha"), ("state", "alpha")),
    ("simulated: tension, N", ("simulated", "tension")),
)  # fmt: skip
_ABOVE = 4
"""views that are seen at once; the others are tabs below"""


def blueprint(rr: Any, shown: Mapping[str, Series], picture: bool) -> Any:
    """The layout for what is shown, by topic."""
    rrb = rr.blueprint
    views = []
    for title, *parts in _VIEWS:
        contents = [
            f"/{topic}/{stem}{k + 1}"
            for topic, stem in parts
            if topic in shown
            for k in range(shown[topic].matrix(stem).shape[1])
        ]
        if contents:
            views.append(rrb.TimeSeriesView(origin="/", contents=contents, name=title))
    curves = rrb.Vertical(*views[:_ABOVE], *([rrb.Tabs(*views[_ABOVE:])] if views[_ABOVE:] else []))
    whole = curves
    if picture:
        whole = rrb.Horizontal(rrb.Spatial2DView(origin=f"/{VIDEO}", name="video"), curves, column_shares=[1, 1])
    return rrb.Blueprint(whole, rrb.TimePanel(timeline="time", state="collapsed"), collapse_panels=True)
