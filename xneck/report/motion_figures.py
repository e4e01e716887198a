"""The arm's motion and the clocks: alpha over time, frame intervals, cable travel on both clocks."""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import log_time
from identification.dataset.dataset import DataSet
from xneck.report import style
from xneck.report.clock_alignment import MIN_GAP_INTERVALS, ClockAlignment, frame_gaps, stretch_of_most_motion
from xneck.report.figure_block import FigureBlock, LegendEntry
from xneck.report.svg import svg_panel

Array = NDArray[np.float64]

SHOWN_S = 4.0
"""s of cable travel that are plotted: a few swings, in which single frames can be seen"""


def alpha_over_time(data: DataSet) -> FigureBlock:
    """One panel a joint: the state with the single frames, and below it their difference."""
    state = data.state
    frames = log_time(data.clock, data.angles.time)
    frame_alpha, alpha = np.degrees(data.angles.matrix("alpha")), np.degrees(state.matrix("alpha"))
    sigma = np.degrees(state.matrix("sigma_alpha"))
    missing = frame_gaps(frames[~np.isnan(frame_alpha).any(axis=1)], float(np.median(np.diff(frames))))
    panels = []
    for i in range(alpha.shape[1]):
        colour = style.joint_colour(i)
        figure, above, below = style.two_row_panel()
        inside = (frames >= state.time[0]) & (frames <= state.time[-1]) & ~np.isnan(frame_alpha[:, i])
        at = frames[inside]
        residual = frame_alpha[inside, i] - np.interp(at, state.time, alpha[:, i])
        reach = 1.15 * max(np.quantile(np.abs(residual), 0.995), 2 * float(np.median(sigma[:, i])), 1e-6)
        for start, end in missing:
            for axes in (above, below):
                style.span(axes, "no angles", start, end, style.GAP, 0.6)
        style.dots(above, "frame", at, frame_alpha[inside, i], colour, size=2.0, opacity=0.45)
        style.line(above, "state", state.time, alpha[:, i], colour)
        time, band = style.decimated(state.time, 2 * sigma[:, i], points=400)
        style.band(below, "±2 σ of the state", time, -band, band, colour, 0.3)
        style.dots(below, "frame − state", at, residual, colour, size=1.8, opacity=0.6, reach=reach)
        below.set_ylim(-reach * 1.05, reach * 1.05)
        above.set_title(f"joint {i + 1}", color=colour)
        above.set_ylabel("alpha, deg")
        below.set_ylabel("frame − state")
        below.set_xlabel(style.LOG_TIME)
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


def travel_on_both_clocks(data: DataSet, alignment: ClockAlignment) -> FigureBlock:
    """Each cable's travel as logged and as vision predicts it, over the seconds of most motion."""
    start, end = stretch_of_most_motion(alignment.time, alignment.logged, SHOWN_S)
    inside = (alignment.time >= start) & (alignment.time <= end)
    fine = (data.state.time >= start) & (data.state.time <= end)
    travel = 1e3 * data.arm.drum * data.state.matrix("theta")[fine]
    panels = []
    for j in range(data.arm.M):
        figure, above, below = style.two_row_panel()
        style.line(
            above, "motor: (rd/R) θ", data.state.time[fine], travel[:, j], style.UNDERLAY, width=style.UNDERLAY_WIDTH
        )
        colour = style.cable_colour(j)
        style.dots(above, "vision", alignment.time[inside], 1e3 * alignment.predicted[inside, j], colour, size=2.4)
        below.axhline(0, color=style.MUTED, linewidth=0.7)
        residual = 1e3 * alignment.residual[:, j]
        reach = max(4 * float(np.quantile(np.abs(residual), 0.75)), 1e-3)
        style.dots(below, "left", alignment.time[inside], residual[inside], colour, size=2.4, reach=reach)
        below.set_ylim(-1.1 * reach, 1.1 * reach)
        above.set_title(f"cable {j + 1}", color=style.cable_colour(j))
        above.set_ylabel("wound in, mm")
        below.set_ylabel("left, mm")
        below.set_xlabel(style.LOG_TIME)
        panels.append(svg_panel(figure, f"travel{j}", f"travel of cable {j + 1} by log and by vision"))
    return FigureBlock(
        "Cable travel on one clock",
        "Once the clocks are aligned, what vision predicts of each cable (dots, with the elongation that the motor "
        f"force explains) lies on the motor's (rd/R) θ (line); of the liveliest {end - start:.0f} s, what is left shows below, "
        "with dots at the edge where a motor reverses and its friction switches.",
        tuple(panels),
        (
            LegendEntry("motor: (rd/R) θ", style.UNDERLAY, "broad"),
            LegendEntry("vision, a dot a frame", style.CABLES[0], "dot"),
        ),
    )


def clock_evidence(data: DataSet, alignment: ClockAlignment) -> FigureBlock:
    """How much worse a wrong clock fits, and the intervals between frames."""
    figure, axes = style.one_row_panel()
    shift_ms = 1e3 * alignment.shifts
    for j in range(alignment.rms.shape[1]):
        style.line(axes, f"cable {j + 1}", shift_ms, 1e3 * alignment.rms[:, j], style.cable_colour(j))
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
    is_long = interval_ms > MIN_GAP_INTERVALS * np.median(interval_ms)
    style.dots(axes, "interval", time[1:][~is_long], interval_ms[~is_long], style.MEASURED, size=2.0)
    style.dots(axes, "longer interval", time[1:][is_long], interval_ms[is_long], style.CABLES[1], size=5.0)
    axes.set_ylim(0, 1.15 * float(interval_ms.max()))
    axes.set_title("frame intervals")
    axes.set_xlabel(style.LOG_TIME)
    axes.set_ylabel("since the last frame, ms")
    intervals = svg_panel(figure, "intervals", "time between frames")
    dropped = data.clock["frames_dropped"]
    return FigureBlock(
        "The clocks",
        "Shifting the clock away from the offset found (grey: its ±2 σ) makes the cables fit worse; one by itself tells the "
        "clock to some milliseconds only. Of the camera's own intervals, "
        f"{dropped} dropped frame{' stands' if dropped == 1 else 's stand'} out.",
        (wrong, intervals),
        (
            *(LegendEntry(f"cable {j + 1}", style.cable_colour(j)) for j in range(alignment.rms.shape[1])),
            LegendEntry("longer interval", style.CABLES[1], "dot"),
        ),
    )
