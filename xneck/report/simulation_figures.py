"""The forces of a recording or of a designed motion through the model, beside the angles that were measured or designed."""

import numpy as np
from numpy.typing import NDArray

from identification.simulation.simulated_motion import SimulatedMotion
from identification.simulation.simulated_recording import SimulatedRecording
from xneck.report import style
from xneck.report.figure_block import FigureBlock, LegendEntry
from xneck.report.svg import svg_panel

Array = NDArray[np.float64]


def simulated_beside_measured(simulated: SimulatedRecording) -> FigureBlock:
    """One panel a joint: both angles, and below their difference."""
    s = simulated.series
    alpha, measured = np.degrees(s.matrix("alpha")), np.degrees(s.matrix("alpha", "_measured"))
    panels = []
    for i in range(alpha.shape[1]):
        colour = style.joint_colour(i)
        figure, above, below = style.two_row_panel()
        style.line(above, "measured", s.time, measured[:, i], style.UNDERLAY, width=style.UNDERLAY_WIDTH)
        time, curve = _by_window(simulated, alpha[:, i])
        style.line(above, "simulated", time, curve, colour, thin=False)
        time, error = _by_window(simulated, alpha[:, i] - measured[:, i])
        below.axhline(0, color=style.MUTED, linewidth=0.7)
        style.line(below, "simulated less measured", time, error, colour, thin=False)
        above.set_title(f"joint {i + 1}", color=colour)
        above.set_ylabel("alpha, deg")
        below.set_ylabel("error, deg")
        below.set_xlabel(style.LOG_TIME)
        panels.append(svg_panel(figure, f"simulated{i}", f"alpha of joint {i + 1}, simulated and measured"))
    return FigureBlock(
        "Simulated beside measured",
        f"Restarted from the measured state every {simulated.window_s:g} s, the model with elastic model 1 drifts away "
        "from the arm by the error below: what it does not know of this arm.",
        tuple(panels),
        (
            LegendEntry("measured", style.UNDERLAY, "broad"),
            LegendEntry("simulated, a stretch a window", style.JOINTS[0]),
        ),
    )


def simulated_beside_designed(simulated: SimulatedMotion) -> FigureBlock:
    """Of a motion that was not played yet, one panel a joint: both angles, and below their difference."""
    s = simulated.series
    alpha, designed = np.degrees(s.matrix("alpha")), np.degrees(s.matrix("alpha", "_designed"))
    panels = []
    for i in range(alpha.shape[1]):
        colour = style.joint_colour(i)
        figure, above, below = style.two_row_panel()
        style.line(above, "designed", s.time, designed[:, i], style.UNDERLAY, width=style.UNDERLAY_WIDTH)
        style.line(above, "simulated", s.time, alpha[:, i], colour)
        below.axhline(0, color=style.MUTED, linewidth=0.7)
        style.line(below, "simulated less designed", s.time, alpha[:, i] - designed[:, i], colour)
        above.set_title(f"joint {i + 1}", color=colour)
        above.set_ylabel("alpha, deg")
        below.set_ylabel("error, deg")
        below.set_xlabel("time, s")
        panels.append(svg_panel(figure, f"designed{i}", f"alpha of joint {i + 1}, simulated and designed"))
    given = {"f": "forces", "theta": "motor angles"}[simulated.source]
    return FigureBlock(
        "Simulated beside designed",
        f"From its first row on, at rest, the model runs under the {given} of the motion; nothing brings it back.",
        tuple(panels),
        (LegendEntry("designed", style.UNDERLAY, "broad"), LegendEntry("simulated", style.JOINTS[0])),
    )


def _by_window(simulated: SimulatedRecording, values: Array) -> tuple[Array, Array]:
    """Time and values with a gap where the simulation was restarted, thinned to MAX_POINTS."""
    time = simulated.series.time
    samples = max(2, round(simulated.window_s / float(np.mean(np.diff(time)))))
    windows = max(1, len(time) // samples)
    stride = max(1, -(-windows * samples // style.MAX_POINTS))
    pick = np.unique(np.r_[np.arange(0, samples, stride), samples - 1])
    index = (np.arange(windows)[:, None] * samples + pick).ravel()
    index = index[index < len(time)]
    last = index % samples == samples - 1
    at = np.flatnonzero(last) + 1
    return np.insert(time[index], at, np.nan), np.insert(values[index], at, np.nan)
