"""The arm at one glance: causes at their places, how far the simulation is off, and the pose where it is furthest off."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import degrees
from textwrap import wrap

import numpy as np
from matplotlib.figure import Figure

from diagnosis.arm_error import ArmError, WorstPose
from diagnosis.cause import Cause
from diagnosis.diagnose import Diagnosis
from mechanism.arm import Arm, Array
from mechanism.cable_path import bar_ends
from mechanism.geometry import poses
from xneck.report import style
from xneck.report.arm_drawing import DrawnArm, draw_bars, draw_drums, draw_way, drawn_arm
from xneck.report.cause_drawing import MARK, cause_places, mark_cause, place_words
from xneck.report.diagnosis_figures import AFTER, BEFORE
from xneck.report.figure_block import FigureBlock, LegendEntry
from xneck.report.number_text import number_text, with_sigma
from xneck.report.recorded_axes import RecordedAxes
from xneck.report.svg import SvgPanel, svg_panel
from xneck.report.words import with_spaces
from xneck_foundation.parameter import Parameter
from xneck_foundation.unit_text import with_unit

_HEIGHT = 3.9
"""in"""
_CALLOUT_CHARACTERS = 20
"""in a line of what a cause is called"""
_LINE = 0.155
"""in, height of a line of text"""
_GAP, _RULE = 0.12, 1.35
"""in: between causes, and of the rule below each"""
_CALLOUTS, _ERRORS = 1.5, 1.65
"""in: room for them on either side of the arm"""
_LEFT, _RIGHT, _BOTTOM, _TOP = 0.62, 0.05, 0.1, 0.3
"""in: margins"""
_HALF_NUMBER = 0.2
"""in: of the last number below an axis, which stands beyond its end by half"""


@dataclass(frozen=True)
class Callout:
    """A cause as it stands beside the arm."""

    lines: tuple[str, ...]
    place: Array | None
    """(2,), m; None where it is no part of the arm"""


def arm_overview(d: Diagnosis) -> FigureBlock:
    """Of a diagnosis; to be called within `style.drawing`."""
    arm, error = d.extended.arm, d.arm_error
    found = list(zip(d.causes, d.numbers, strict=True))
    panels = [places_panel(arm, found, error, d.is_extended)]
    legend = [LegendEntry("where a cause acts", MARK, "broad")] if d.causes else []
    if error is not None:
        panels.append(_worst_pose_panel(arm, error.worst, d.is_extended))
        legend.append(LegendEntry("as measured", style.UNDERLAY, "broad"))
        legend.append(LegendEntry("base model", BEFORE, "dashed"))
        if d.is_extended:
            legend.append(LegendEntry("extended model", AFTER))
    return FigureBlock("The arm", _caption(d), tuple(panels), tuple(legend))


def _caption(d: Diagnosis) -> str:
    error = d.arm_error
    if error is None:
        why = d.not_simulated or "no recordings were held out (--held-out)"
        return f"How far the simulated arm is off is not known: {why}."
    now = ", and with what was found" if d.is_extended else ""
    noise = degrees(float(error.joints_noise.max()))
    return (
        f"How far the simulation is off, RMS, at each joint and at the middle of the top bar: by the base model{now}, on "
        f"recordings that were not fitted. Noise alone would leave {number_text(noise, 2)}° at a joint."
    )


def error_words(before: float, after: float, unit: str, is_extended: bool) -> str:
    """Such as `4.7° → 0.05°`, with the unit once where it is a word."""
    first, last = number_text(before, 2), number_text(after, 2)
    space = "" if unit == "°" else " "
    if not is_extended:
        return f"{first}{space}{unit}"
    return f"{first}{unit if unit == '°' else ''} → {last}{space}{unit}"


def places_panel(
    arm: Arm, found: Sequence[tuple[Cause, Sequence[Parameter]]], error: ArmError | None, is_extended: bool
) -> SvgPanel:
    """The arm upright, with causes and their numbers on the left of it and its errors on the right."""
    drawn = drawn_arm(arm)
    figure, axes, inch = _axes_for(drawn)
    for cause, _ in found:
        mark_cause(axes, drawn, cause)
    draw_bars(axes, drawn)
    for j in range(arm.M):
        draw_way(axes, f"cable {j + 1}", 1e3 * drawn.cable(j), style.cable_colour(j), 1.2)
    draw_drums(axes, drawn)
    _draw_callouts(axes, _callouts(found, drawn), inch)
    if error is not None:
        _draw_errors(axes, drawn, error, is_extended, inch)
    words = "; ".join(f"{with_spaces(c.effect.name)}: {place_words(c, arm)}" for c, _ in found)
    told = ["causes"] * bool(found) + ["how far the simulation is off"] * (error is not None)
    axes.set_title(", and ".join(told) or "the arm")
    return svg_panel(figure, "overview", f"the arm, and how far it is off{f'; marked: {words}' if words else ''}")


def _axes_for(drawn: DrawnArm) -> tuple[Figure, RecordedAxes, float]:
    """A figure for the straight arm in the middle with room on both sides, and how many mm of the arm an inch of it is."""
    figure = Figure(figsize=(style.WIDTH, _HEIGHT))
    width, height = style.WIDTH - _LEFT - _RIGHT, _HEIGHT - _BOTTOM - _TOP
    place = (_LEFT / style.WIDTH, _BOTTOM / _HEIGHT, width / style.WIDTH, height / _HEIGHT)
    axes = RecordedAxes(figure, place)
    discs = 1e3 * np.concatenate([drawn.drums - 1.6 * drawn.drum_radius, drawn.drums + 1.6 * drawn.drum_radius])
    points = np.concatenate([discs, 1e3 * 1.5 * drawn.ends[0], 1e3 * drawn.ends.reshape(-1, 2)])
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    inch = float(max((high - low) / (height - 3 * _LINE), (right - left) / (width - _CALLOUTS - _ERRORS)))
    spare = (width - _CALLOUTS - _ERRORS) * inch - (right - left)
    axes.set_xlim(left - spare / 2 - _CALLOUTS * inch, right + spare / 2 + _ERRORS * inch)
    lowest = low - max(height * inch - (high - low) - 3 * _LINE * inch, 0) / 2
    axes.set_ylim(lowest, lowest + height * inch)
    axes.set_aspect("equal", adjustable="box")
    axes.set_ylabel("mm above the base")
    axes.yaxis.set_label_coords((0.16 - _LEFT) / width, 0.5)
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)
    axes.grid(visible=False)
    return figure, axes, inch


def _callouts(found: Sequence[tuple[Cause, Sequence[Parameter]]], drawn: DrawnArm) -> list[Callout]:
    """From the top down."""
    callouts = []
    for number, (cause, parameters) in enumerate(found, start=1):
        several = len(cause.effect.place_labels(drawn.arm)) > 1
        where = f", {place_words(cause, drawn.arm)}" if several else ""
        lines = wrap(f"{number}\u2002{with_spaces(cause.effect.name)}{where}", _CALLOUT_CHARACTERS)
        amounts = [p for p in parameters if p.name == cause.effect.terms[0].name]
        if len(amounts) == 1:
            (p,) = amounts
            lines.append(f"{p.name} = {with_unit(with_sigma(p.value, p.sigma), p.unit)}")
        places = cause_places(drawn, cause)
        callouts.append(Callout(tuple(lines), places[np.argmin(places[:, 0])] if len(places) else None))
    return sorted(callouts, key=lambda c: -np.inf if c.place is None else c.place[1], reverse=True)


def _draw_callouts(axes: RecordedAxes, callouts: Sequence[Callout], inch: float) -> None:
    """On the left, each as high as its place where there is room, with a line to it."""
    x, (low, top) = axes.get_xlim()[0] + 0.06 * inch, axes.get_ylim()
    heights = [(_LINE * len(c.lines) + _GAP) * inch for c in callouts]
    for k, (callout, height) in enumerate(zip(callouts, heights, strict=True)):
        wanted = low if callout.place is None else 1e3 * callout.place[1]
        bottom = min(max(wanted, low + sum(heights[k + 1 :])), top - height)
        for n, line in enumerate(reversed(callout.lines)):
            weight = "bold" if n + 1 == len(callout.lines) or not line.count("=") else "normal"
            axes.text(
                x, bottom + (n * _LINE + 0.04) * inch, line, fontsize=8.0, fontweight=weight, color=style.MEASURED
            )
        if callout.place is not None:
            to_x, to_y = 1e3 * callout.place
            axes.plot([x, x + _RULE * inch, to_x], [bottom, bottom, to_y], color=MARK, linewidth=1.0, zorder=0)
            axes.record(" ".join(callout.lines), "dots", x=[to_x], y=[to_y])
        top = bottom


def _draw_errors(axes: RecordedAxes, drawn: DrawnArm, error: ArmError, is_extended: bool, inch: float) -> None:
    """On the right, each as high as its joint, and the tip's above."""
    x = axes.get_xlim()[1] - (_ERRORS - 0.05) * inch
    tip = 1e3 * float(drawn.ends[-1, 0, 1])
    rows = [("tip", tip, 1e3 * error.tip_before, 1e3 * error.tip_after, "mm", style.MEASURED)]
    for i, (before, after) in enumerate(zip(error.joints_before.tolist(), error.joints_after.tolist(), strict=True)):
        height = 1e3 * float(drawn.joint(i)[1])
        rows.append((f"joint {i + 1}", height, degrees(before), degrees(after), "°", style.joint_colour(i)))
    for name, y, before, after, unit, colour in rows:
        words = error_words(before, after, unit, is_extended)
        axes.text(x, y, f"{name}: {words}", fontsize=8.0, fontweight="bold", va="center", color=colour)
        axes.record(f"{name}, {unit}", "dots", x=[before, after], y=[y, y])


def _worst_pose_panel(arm: Arm, worst: WorstPose, is_extended: bool) -> SvgPanel:
    figure = Figure(figsize=(style.WIDTH, _HEIGHT))
    width, height = style.WIDTH - 0.68 - _HALF_NUMBER, _HEIGHT - 0.46 - _TOP
    axes = RecordedAxes(figure, (0.68 / style.WIDTH, 0.46 / _HEIGHT, width / style.WIDTH, height / _HEIGHT))
    axes.yaxis.set_label_coords((0.16 - 0.68) / width, 0.5)
    _draw_pose(axes, "as measured", arm, worst.measured, style.UNDERLAY, 4.0)
    _draw_pose(axes, "base model", arm, worst.before, BEFORE, 1.3, (4.0, 2.0))
    if is_extended:
        _draw_pose(axes, "extended model", arm, worst.after, AFTER, 1.1)
    off = 1e3 * abs(complex(_tip(arm, worst.before) - _tip(arm, worst.measured)))
    axes.set_title(f"where it is furthest off: tip {number_text(off, 2)} mm, at {worst.time:.2f} s")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_ylabel("mm above the base")
    axes.set_xlabel("mm to the right")
    axes.grid(visible=False)
    return svg_panel(figure, "worst", "the arm as measured and as simulated, where the base model is furthest off")


def _tip(arm: Arm, alpha: Array) -> np.complex128:
    return poses(arm, alpha).bar_middle[-1]


def _draw_pose(
    axes: RecordedAxes,
    name: str,
    arm: Arm,
    alpha: Array,
    colour: str,
    width: float,
    dashes: tuple[float, float] | None = None,
) -> None:
    """Bars and diagonals as one line with gaps, mm."""
    ends = bar_ends(arm, poses(arm, alpha))
    gap = complex(np.nan, np.nan)
    way = [point for left, right in ends for point in (left, right, gap)]
    for (a, b), (c, d) in pairwise(ends):
        way += [a, d, gap, b, c, gap]
    points = 1e3 * np.array(way, dtype=complex)
    (line,) = axes.plot(points.real, points.imag, color=colour, linewidth=width, solid_capstyle="round")
    if dashes is not None:
        line.set_dashes(dashes)
    axes.record(name, "outline", x=points.real, y=points.imag)
