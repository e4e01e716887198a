"""The layout by which PlotJuggler opens a data set: it loads the file beside it, and plots named curves.

PlotJuggler names the curves of a JointState `/topic/joint/position`.
"""

from collections.abc import Mapping
from xml.etree import ElementTree as ET

from identification.dataset.series import Series
from xneck.viewers.panels import PlotPanel, plot_panels

_MAX_ARRAY_SIZE = 10_000
"""longest array that PlotJuggler reads; JointState is read joint by joint, whatever their number"""


def plotjuggler_layout(series: Mapping[str, Series], data_file: str) -> str:
    """A layout file for a data set with these series, by topic, in the file `data_file` beside it."""
    plots = plot_panels(series)
    root = ET.Element("root")
    tabs = ET.SubElement(root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"})
    tab = ET.SubElement(tabs, "Tab", {"tab_name": "xneck", "containers": "1"})
    container = ET.SubElement(tab, "Container")
    half = (len(plots) + 1) // 2
    columns = [part for part in (plots[:half], plots[half:]) if part]
    side_by_side = _split(container, "|", len(columns))
    for part in columns:
        column = _split(side_by_side, "-", len(part))
        for panel in part:
            _plot(ET.SubElement(column, "DockArea", {"name": panel.title}), panel)
    ET.SubElement(tabs, "currentTabIndex", {"index": "0"})
    ET.SubElement(root, "use_relative_time_offset", {"enabled": "1"})
    loaded = ET.SubElement(root, "previouslyLoaded_Datafiles")
    file = ET.SubElement(loaded, "fileInfo", {"filename": data_file, "prefix": ""})
    plugin = ET.SubElement(file, "plugin", {"ID": "DataLoad MCAP"})
    ET.SubElement(
        plugin,
        "parameters",
        {
            "use_timestamp": "0",
            "use_mcap_log_time": "1",  # frames are stamped by the camera's clock
            "clamp_large_arrays": "0",
            "max_array_size": str(_MAX_ARRAY_SIZE),
            "selected_topics": ";".join(f"/{topic}" for topic in series),
        },
    )
    ET.indent(root)
    return ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _split(parent: ET.Element, direction: str, count: int) -> ET.Element:
    """A place of `count` equal parts, side by side (`|`) or one above the other (`-`)."""
    sizes = ";".join([f"{1 / count:.6f}"] * count)
    return ET.SubElement(parent, "DockSplitter", {"orientation": direction, "count": str(count), "sizes": sizes})


def _plot(parent: ET.Element, panel: PlotPanel) -> None:
    plot = ET.SubElement(parent, "plot", {"mode": "TimeSeries", "style": "Lines", "line_width": "1.0"})
    for curve in panel.curves:
        name = f"/{curve.topic}/{curve.column}/position"
        ET.SubElement(plot, "curve", {"name": name, "color": curve.colour})
