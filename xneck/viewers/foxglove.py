"""The layout by which Foxglove (and Lichtblick, its open fork) opens a data set: plots of named curves.

A message path of Foxglove takes an element of JointState by its position only: the position is looked up in the series, and the
name is the curve's label. The time is the message's, on the log's clock, for frames too.
"""

import json
from collections.abc import Mapping
from typing import Any

from identification.dataset.series import Series
from xneck.viewers.panels import PlotPanel, plot_panels


def foxglove_layout(series: Mapping[str, Series]) -> str:
    """A layout file for a data set with these series, by topic."""
    plots = plot_panels(series)
    names = [f"Plot!xneck{k + 1}" for k in range(len(plots))]
    half = (len(names) + 1) // 2
    columns = [_split_equally(part, "column") for part in (names[:half], names[half:]) if part]
    layout = {
        "configById": {name: _plot(panel, series) for name, panel in zip(names, plots, strict=True)},
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split_equally(columns, "row"),
    }
    return json.dumps(layout, indent=1) + "\n"


def _plot(panel: PlotPanel, series: Mapping[str, Series]) -> dict[str, Any]:
    paths = [
        {
            "value": f"/{curve.topic}.position[{list(series[curve.topic].columns).index(curve.column)}]",
            "label": f"{curve.topic} {curve.column}",
            "color": curve.colour,
            "enabled": True,
            "timestampMethod": "receiveTime",
            "showLine": not curve.dots,
            "lineSize": 2 if curve.dots else 1.2,
        }
        for curve in panel.curves
    ]
    return {
        "foxglovePanelTitle": panel.title,
        "paths": paths,
        "xAxisVal": "timestamp",
        "isSynced": True,
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": True,
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "sidebarDimension": 240,
    }


def _split_equally(parts: list[Any], direction: str) -> Any:
    """Panels in a row or a column with equal shares, as the nested splits that Foxglove asks for."""
    first, *rest = parts
    if not rest:
        return first
    share = 100 / len(parts)
    return {"direction": direction, "first": first, "second": _split_equally(rest, direction), "splitPercentage": share}
