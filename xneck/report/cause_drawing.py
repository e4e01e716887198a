"""Marks, on a drawing of the arm, of the places where a cause acts."""

import numpy as np

from diagnosis.cause import Cause
from mechanism.arm import Arm, Array
from xneck.report.arm_drawing import DrawnArm, draw_way, ring
from xneck.report.recorded_axes import RecordedAxes

MARK = "#DDAA33"
"""colour of what is marked: Tol's high-contrast yellow, which stands out from bars and cables in grey print too"""
_MARK_WIDTH = 7.0


def place_words(cause: Cause, arm: Arm) -> str:
    """Such as `motor 3`, `all cables` or `tip`."""
    if cause.where.label != "all":
        return cause.where.label
    return f"all {cause.effect.place}s" if len(cause.effect.place_labels(arm)) > 1 else cause.effect.place


def cause_places(drawn: DrawnArm, cause: Cause) -> Array:
    """A point of each place where a cause acts, (K, 2), m; none where that is no part of the arm."""
    points = [_middle(drawn, cause.effect.part or cause.effect.place, place) for place in cause.places(drawn.arm)]
    return np.array([point for point in points if point is not None]).reshape(-1, 2)


def mark_cause(axes: RecordedAxes, drawn: DrawnArm, cause: Cause) -> None:
    """Marks what a cause is of, behind the arm and broad."""
    effect, arm = cause.effect, drawn.arm
    name = f"{effect.name}, {cause.where.label}"
    for place in cause.places(arm):
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


def _middle(drawn: DrawnArm, part: str, place: int) -> Array | None:
    """To which a line may lead, (2,), m."""
    match part:
        case "motor":
            return drawn.drums[place] - np.array([1.6 * drawn.drum_radius, 0.0])
        case "cable":
            return drawn.cable(place)[:2].mean(axis=0)
        case "joint":
            return drawn.joint(place)
        case "springs":
            return drawn.side(place, 0).mean(axis=0)
        case "pulleys":
            return drawn.ends[place, 0]
        case "bar":
            return drawn.ends[place, 0]
        case "tip":
            return drawn.ends[-1].mean(axis=0)
        case "base":
            return 1.5 * drawn.ends[0, 0]
        case _:
            return None


def _disc(axes: RecordedAxes, name: str, middle: Array, radius: float) -> None:
    points = ring(middle, radius)
    axes.fill(*points.T, color=MARK, linewidth=0, zorder=1)
    axes.record(name, "outline", x=points[:, 0], y=points[:, 1])
