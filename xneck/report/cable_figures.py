"""Elongations of the cables, over time and against the motor force."""

import numpy as np
from scipy.ndimage import median_filter

from identification.dataset.dataset import DataSet
from synchronisation.check.explained_elongation import ExplainedElongation
from xneck.report import style
from xneck.report.figure_block import FigureBlock, LegendEntry
from xneck.report.svg import svg_panel

MEDIAN_S = 0.5
"""s, width of the running median over the unexplained elongation"""


def elongation_over_time(data: DataSet, elongation: ExplainedElongation) -> FigureBlock:
    """Elongations of all cables in one panel, and what the motor force does not explain of them in another."""
    panels = []
    time = data.state.time
    stride = max(1, len(time) // (2 * style.MAX_POINTS))
    width = max(1, round(MEDIAN_S / (stride * float(np.mean(np.diff(time))))))
    unexplained = median_filter((elongation.x - elongation.explained)[::stride], size=(width, 1), mode="nearest")
    for key, title, at, values in (
        ("elongation", "all cables", time, elongation.x),
        ("unexplained", "not explained by the force", time[::stride], unexplained),
    ):
        figure, axes = style.one_row_panel(2.7)
        for j in range(data.arm.M):
            style.line(axes, f"cable {j + 1}", at, 1e3 * values[:, j], style.cable_colour(j))
        axes.set_title(title)
        axes.set_xlabel(style.LOG_TIME)
        axes.set_ylabel("elongation x, mm" if key == "elongation" else "unexplained, mm")
        panels.append(svg_panel(figure, key, f"elongation of all cables over time: {title}"))
    return FigureBlock(
        "Elongations over time",
        "What the motors wound in beyond what the angles seen allow for, and what of it the motor force does not explain "
        f"(median of {MEDIAN_S:g} s, since every reversal makes a spike): a healthy cable stays near zero, a slipping or "
        "mislabelled one drifts or jumps.",
        tuple(panels),
        legend=tuple(LegendEntry(f"cable {j + 1}", style.cable_colour(j)) for j in range(data.arm.M)),
    )


def elongation_against_force(data: DataSet, elongation: ExplainedElongation) -> FigureBlock:
    """One panel a cable: winding in and paying out as dots of two colours, and the check's law as lines."""
    speed = data.state.matrix("theta", "_d")
    panels = []
    for j in range(data.arm.M):
        figure, axes = style.one_row_panel()
        colour, n, x = style.cable_colour(j), elongation.force[:, j], 1e3 * elongation.x[:, j]
        for turning, name, dot_colour in ((1, "winding in", colour), (-1, "paying out", style.MUTED)):
            moving = turning * speed[:, j] > 0
            style.dots(axes, name, n[moving], x[moving], dot_colour, size=2.0, opacity=0.6)
            if np.any(moving):
                low, high = np.quantile(n[moving], [0.005, 0.995]).tolist()
                force = np.linspace(low, high, 30)
                law = 1e3 * elongation.curve(j, force, turning)
                style.line(axes, f"the check's law, {name}", force, law, style.MEASURED, "dashed")
        axes.set_title(f"cable {j + 1}", color=colour)
        axes.set_xlabel("motor force less its inertia, N")
        axes.set_ylabel("elongation x, mm")
        panels.append(svg_panel(figure, f"force{j}", f"elongation of cable {j + 1} against its motor force"))
    return FigureBlock(
        "Elongation against force",
        "Each cable grows with its force along the check's law (dashed); winding in lies to the right of paying out by "
        "twice the dry friction, and dots between the two are reversals.",
        tuple(panels),
        legend=(
            LegendEntry("winding in", style.CABLES[0], "dot"),
            LegendEntry("paying out", style.MUTED, "dot"),
            LegendEntry("the check's law", style.MEASURED, "dashed"),
        ),
    )
