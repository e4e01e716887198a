"""The arm's motion and the clocks: alpha over time, frame intervals, cable travel on both clocks."""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import log_time
from identification.dataset.dataset import DataSet
from xneck.report import style
from xneck.report.clock_alignment import ClockAlignment, frame_gaps, stretch_of_most_motion
from xneck.report.figure_block import FigureBlock, LegendEntry
from xneck.report.svg import svg_panel

Array = NDArray[np.float64]

SHOWN_S = 4.0
"""s of cable travel: long enough for a few swings, short enough to see single frames"""


def alpha_over_time(data: DataSet) -> FigureBlock:
    """One panel a joint: the state with the raw frames, and below what lies between them."""
    state = data.state
    frames = log_time(data.clock, data.angles.time)
    seen, alpha = np.degrees(data.angles.matrix("alpha")), np.degrees(state.matrix("alpha"))
    sigma = np.degrees(state.matrix("sigma_alpha"))
    missing = frame_gaps(frames[~np.isnan(seen).any(axis=1)], float(np.median(np.diff(frames))))
    panels = []
    for i in range(alpha.shape[1]):
        colour = style.joint_colour(i)
        figure, above, below = style.two_row_panel()
        inside = (frames >= state.time[0]) & (frames <= state.time[-1]) & ~np.isnan(seen[:, i])
        at = frames[inside]
        away = seen[inside, i] - np.interp(at, state.time, alpha[:, i])
        reach = 1.15 * max(np.quantile(np.abs(away), 0.995), 2 * float(np.median(sigma[:, i])), 1e-6)
        for start, end in missing:
            for axes in (above, below):
                style.span(axes, "no angles", start, end, style.GAP, 0.6)
        style.dots(above, "frame", at, seen[inside, i], colour, size=2.0, opacity=0.45)
        style.line(above, "state", state.time, alpha[:, i], colour)
        time, band = style.decimated(state.time, 2 * sigma[:, i], points=400)
        style.band(below, "±2 σ of the state", time, -band, band, colour, 0.3)
        style.dots(below, "frame − state", at, away, colour, size=1.8, opacity=0.6, reach=reach)
        below.set_ylim(-reach * 1.05, reach * 1.05)
        above.set_title(f"joint {i + 1}", color=colour)
        above.set_ylabel("alpha, deg")
        below.set_ylabel("frame − state")
        below.set_xlabel("time on the log's clock, s")
        panels.append(svg_panel(figure, f"alpha{i}", f"alpha of joint {i + 1} over time"))
    typical = float(np.sqrt(np.mean(sigma**2)))
    where = f"{len(missing)} gaps are shaded" if missing else "no frame is missing"
    return FigureBlock(
        "Angles of the joints",
        f"The line is the smoothed state and the dots are single frames; below, what separates them in degrees, with "
        f"the state's ±2 σ as a band (σ is {typical:.3f} deg on average); {where}.",
        tuple(panels),
        (
            LegendEntry("state", style.MEASURED),
            LegendEntry("frame", style.MEASURED, "dot"),
            LegendEntry("±2 σ of the state", style.MEASURED, "band"),
            LegendEntry("no angles", style.GAP, "band"),
        ),
    )


def travel_on_both_clocks(data: DataSet, found: ClockAlignment) -> FigureBlock:
    """Each cable's travel as logged and as vision predicts it, over the liveliest seconds."""
    start, end = stretch_of_most_motion(found.time, found.logged, SHOWN_S)
    inside = (found.time >= start) & (found.time <= end)
    fine = (data.state.time >= start) & (data.state.time <= end)
    travel = 1e3 * data.arm.drum * data.state.matrix("theta")[fine]
    panels = []
    for j in range(data.arm.M):
        figure, above, below = style.two_row_panel()
        style.line(above, "motor: (rd/R) θ", data.state.time[fine], travel[:, j], style.UNDERLAY, width=style.UNDERLAY_WIDTH)
        colour = style.cable_colour(j)
        style.dots(above, "vision", found.time[inside], 1e3 * found.predicted[inside, j], colour, size=2.4)
        below.axhline(0, color=style.MUTED, linewidth=0.7)
        left = 1e3 * found.left[:, j]
        reach = max(4 * float(np.quantile(np.abs(left), 0.75)), 1e-3)
        style.dots(below, "left", found.time[inside], left[inside], colour, size=2.4, reach=reach)
        below.set_ylim(-1.1 * reach, 1.1 * reach)
        above.set_title(f"cable {j + 1}", color=style.cable_colour(j))
        above.set_ylabel("wound in, mm")
        below.set_ylabel("left, mm")
        below.set_xlabel("time on the log's clock, s")
        panels.append(svg_panel(figure, f"travel{j}", f"travel of cable {j + 1} by log and by vision"))
    return FigureBlock(
        "Cable travel on one clock",
        "Once the clocks are aligned, what vision predicts of each cable (dots, with the elongation that the motor "
        f"force explains) lies on the motor's (rd/R) θ (line); of the liveliest {end - start:.0f} s, what is left shows below, "
        "with dots at the edge where a motor reverses and its friction switches.",
        tuple(panels),
        (LegendEntry("motor: (rd/R) θ", style.UNDERLAY, "broad"), LegendEntry("vision, a dot a frame", style.CABLES[0], "dot")),
    )


def clock_evidence(data: DataSet, found: ClockAlignment) -> FigureBlock:
    """What a wrong clock would cost, and the frame intervals."""
    figure, axes = style.one_row_panel()
    shift_ms = 1e3 * found.shifts
    for j in range(found.rms.shape[1]):
        style.line(axes, f"cable {j + 1}", shift_ms, 1e3 * found.rms[:, j], style.cable_colour(j))
    sigma_ms = 2e3 * data.clock["offset_sigma_s"]
    style.span(axes, "±2 σ of the offset", -sigma_ms, sigma_ms, style.MUTED, 0.4)
    axes.set_ylim(bottom=0)
    axes.set_title("a wrong clock")
    axes.set_xlabel("shift against the offset found, ms")
    axes.set_ylabel("RMS left, mm")
    wrong = svg_panel(figure, "clock", "RMS of the cable travel that is left when the clock is shifted")

    figure, axes = style.one_row_panel()
    time = log_time(data.clock, data.angles.time)
    interval_ms = 1e3 * np.diff(data.angles.time)
    late = interval_ms > 1.5 * np.median(interval_ms)
    style.dots(axes, "interval", time[1:][~late], interval_ms[~late], style.MEASURED, size=2.0)
    style.dots(axes, "longer interval", time[1:][late], interval_ms[late], style.CABLES[1], size=5.0)
    axes.set_ylim(0, 1.15 * float(interval_ms.max()))
    axes.set_title("frame intervals")
    axes.set_xlabel("time on the log's clock, s")
    axes.set_ylabel("since the last frame, ms")
    intervals = svg_panel(figure, "intervals", "time between frames")
    dropped = data.clock["frames_dropped"]
    return FigureBlock(
        "The clocks",
        "Shifting the clock away from the offset found (grey: its ±2 σ) makes every cable fit worse; of the "
        f"camera's own intervals, {dropped} dropped frame{' stands' if dropped == 1 else 's stand'} out.",
        (wrong, intervals),
        (
            *(LegendEntry(f"cable {j + 1}", style.cable_colour(j)) for j in range(found.rms.shape[1])),
            LegendEntry("longer interval", style.CABLES[1], "dot"),
        ),
    )
