"""The arm upright with the place of a cause marked."""

from matplotlib.figure import Figure

from diagnosis.cause import Cause
from mechanism.arm import Arm, Array
from xneck.report import style
from xneck.report.arm_drawing import (
    DrawnArm,
    draw_bars,
    draw_drums,
    draw_way,
    drawn_arm,
    name_joints,
    ring,
)
from xneck.report.recorded_axes import RecordedAxes
from xneck.report.svg import SvgPanel, svg_panel

MARK = "#DDAA33"
"""colour of what is marked: Tol's high-contrast yellow, which stands out from bars and cables in grey print too"""
_MARK_WIDTH = 7.0
_HEIGHT = 3.2
"""in"""


def arm_panel(arm: Arm, cause: Cause, key: str) -> SvgPanel:
    """The arm with the place of a cause marked."""
    drawn = drawn_arm(arm)
    height = float(drawn.ends[-1, 0, 1] - drawn.drums[0, 1])
    figure = Figure(figsize=(style.WIDTH, _HEIGHT))
    axes = RecordedAxes(
        figure, (0.68 / style.WIDTH, 0.46 / _HEIGHT, (style.WIDTH - 0.8) / style.WIDTH, 1 - 0.76 / _HEIGHT)
    )
    axes.yaxis.set_label_coords((0.16 - 0.68) / (style.WIDTH - 0.8), 0.5)
    _mark(axes, drawn, cause)
    draw_bars(axes, drawn)
    for j in range(arm.M):
        draw_way(axes, f"cable {j + 1}", 1e3 * drawn.cable(j), style.cable_colour(j), 1.2)
    draw_drums(axes, drawn)
    name_joints(axes, drawn)
    words = place_words(cause, arm)
    axes.set_title(f"where it acts: {words}")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_ylim(1e3 * (drawn.drums[0, 1] - 0.12 * height), 1e3 * (drawn.ends[-1, 0, 1] + 0.1 * height))
    axes.set_ylabel("mm above the base")
    axes.set_xlabel("mm to the right")
    axes.grid(visible=False)
    return svg_panel(figure, key, f"the arm, with {words} marked")


def place_words(cause: Cause, arm: Arm) -> str:
    """Such as `motor 3`, `all cables` or `tip`."""
    if cause.where.label != "all":
        return cause.where.label
    return f"all {cause.effect.place}s" if len(cause.effect.place_labels(arm)) > 1 else cause.effect.place


def _mark(axes: RecordedAxes, drawn: DrawnArm, cause: Cause) -> None:
    """What a cause is of, behind the arm and broad."""
    effect, arm = cause.effect, drawn.arm
    count = len(effect.place_labels(arm))
    places = sorted({column % count for column in cause.where.columns})
    name = f"{effect.name}, {cause.where.label}"
    for place in places:
        match effect.part or effect.place:
            case "motor":
                _disc(axes, name, drawn.drums[place], 1.6 * drawn.drum_radius)
            case "cable":
                draw_way(axes, name, 1e3 * drawn.cable(place), MARK, _MARK_WIDTH)
            case "joint":
                _disc(axes, name, drawn.joint(place), 0.3 * float(arm.b[place]))
            case "springs":
                for right in (0, 1):
                    draw_way(axes, name, 1e3 * drawn.side(place, right), MARK, _MARK_WIDTH)
            case "pulleys":
                for end in drawn.ends[place : place + 2].reshape(-1, 2):
                    _disc(axes, name, end, 2.6 * float(arm.r[place]))
            case "bar":
                draw_way(axes, name, 1e3 * drawn.ends[place], MARK, 1.6 * _MARK_WIDTH)
            case "tip":
                _disc(axes, name, drawn.ends[-1].mean(axis=0), 0.3 * float(arm.b[-1]))
            case "base":
                draw_way(axes, name, 1e3 * 1.5 * drawn.ends[0], MARK, 1.6 * _MARK_WIDTH)
            case _:  # the camera, or another thing that is no part of the arm
                pass


def _disc(axes: RecordedAxes, name: str, middle: Array, radius: float) -> None:
    points = ring(middle, radius)
    axes.fill(*points.T, color=MARK, linewidth=0, zorder=1)
    axes.record(name, "outline", x=points[:, 0], y=points[:, 1])
