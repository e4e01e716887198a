"""The arm upright, drawn from its description, with the places of causes marked."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from diagnosis.cause import Cause
from mechanism.arm import Arm
from mechanism.geometry import poses
from xneck.report import style
from xneck.report.recorded_axes import RecordedAxes
from xneck.report.svg import SvgPanel, svg_panel

Array = NDArray[np.float64]

MARK = "#DDAA33"
"""colour of what is marked: Tol's high-contrast yellow, which stands out from bars and cables in grey print too"""
_BARS, _PULLEYS = "#555555", "#777777"
_MARK_WIDTH = 7.0
_HEIGHT = 3.2
"""in"""
_DRUM_SHARE = 0.22
"""of a bar: what a drum is drawn with, larger than it is, so that its number can be read"""


@dataclass(frozen=True)
class UprightArm:
    """Points of an arm whose joints are all straight, m; bars 0..N from the base up."""

    arm: Arm
    ends: Array
    """of every bar: left, then right, (N + 1, 2, 2)"""
    drums: Array
    """middles of the motors' drums, side by side below the base, (M, 2)"""
    drum_radius: float

    def joint(self, mechanism: int) -> Array:
        """Where its diagonals cross, (2,)."""
        return self.ends[mechanism : mechanism + 2].mean(axis=(0, 1))

    def side(self, mechanism: int, right: int) -> Array:
        """The ends that a spring joins, (2, 2)."""
        return self.ends[mechanism : mechanism + 2, right]

    def cable(self, j: int) -> Array:
        """The way of a cable from its drum, by the pulleys that it passes, (P, 2)."""
        route = self.arm.routes[j]
        right = _is_right(route[0])
        beside = np.array([(j - (self.arm.M - 1) / 2) * 0.5 * float(self.arm.r[0]), 0.0])
        way = [self.drums[j] - beside, self.ends[0, int(right)]]
        for i, word in enumerate(route):
            right = _is_right(word)
            if word.startswith("strut"):  # by the diagonal to the other side, and back along the top bar
                way.append(self.ends[i + 1, int(not right)])
            way.append(self.ends[i + 1, int(right)])
        return np.array(way) + beside


def upright(arm: Arm) -> UprightArm:
    """The arm with all joint angles zero."""
    pose = poses(arm, np.zeros(arm.N))
    middle = np.stack([pose.bar_middle.real, pose.bar_middle.imag], axis=-1)
    half = np.concatenate([arm.b[:1], arm.b]) / 2
    ends = middle[:, None] + half[:, None, None] * np.array([[-1.0, 0.0], [1.0, 0.0]])
    radius = _DRUM_SHARE * float(arm.b[0])
    # drums in the order of the sides on which their cables go up, so that no cable crosses another below the base
    order = np.argsort([_is_right(route[0]) for route in arm.routes], kind="stable")
    x = np.empty(arm.M)
    x[order] = (np.arange(arm.M) - (arm.M - 1) / 2) * 2.6 * radius
    return UprightArm(arm, ends, np.stack([x, np.full(arm.M, -0.6 * float(arm.L[0]))], axis=-1), radius)


def _is_right(word: str) -> bool:
    """Whether a portion of a cable begins and ends on the right."""
    return not word.startswith("left") and word != "strut_mirrored"


def arm_panel(arm: Arm, cause: Cause, key: str) -> SvgPanel:
    """The arm with the place of a cause marked."""
    drawn = upright(arm)
    height = float(drawn.ends[-1, 0, 1] - drawn.drums[0, 1])
    figure = Figure(figsize=(style.WIDTH, _HEIGHT))
    axes = RecordedAxes(
        figure, (0.68 / style.WIDTH, 0.46 / _HEIGHT, (style.WIDTH - 0.8) / style.WIDTH, 1 - 0.76 / _HEIGHT)
    )
    axes.yaxis.set_label_coords((0.16 - 0.68) / (style.WIDTH - 0.8), 0.5)
    _mark(axes, drawn, cause)
    _bars(axes, drawn)
    for j in range(arm.M):
        _way(axes, f"cable {j + 1}", 1e3 * drawn.cable(j), style.cable_colour(j), 1.2)
        _circle(axes, f"drum {j + 1}", drawn.drums[j], drawn.drum_radius, style.cable_colour(j))
        x, y = 1e3 * drawn.drums[j]
        axes.text(x, y, str(j + 1), ha="center", va="center_baseline", fontsize=7.5, color=style.MEASURED)
    for i in range(arm.N):
        x, y = 1e3 * drawn.joint(i)
        axes.text(x + 0.9e3 * arm.b[i], y, f"joint {i + 1}", va="center", fontsize=8.0, color=style.joint_colour(i))
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


def _bars(axes: RecordedAxes, drawn: UprightArm) -> None:
    arm = drawn.arm
    for i, (left, right) in enumerate(drawn.ends):
        _way(axes, f"bar {i}", 1e3 * np.array([left, right]), _BARS, 2.6)
        for end in (left, right):
            _circle(axes, "pulley", end, float(arm.r[min(i, arm.N - 1)]), _PULLEYS)
    for i in range(arm.N):
        (a, b), (c, d) = drawn.ends[i], drawn.ends[i + 1]
        for ends in ((a, d), (b, c)):
            _way(axes, f"diagonal of mechanism {i + 1}", 1e3 * np.array(ends), _BARS, 1.6)


def _mark(axes: RecordedAxes, drawn: UprightArm, cause: Cause) -> None:
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
                _way(axes, name, 1e3 * drawn.cable(place), MARK, _MARK_WIDTH)
            case "joint":
                _disc(axes, name, drawn.joint(place), 0.3 * float(arm.b[place]))
            case "springs":
                for right in (0, 1):
                    _way(axes, name, 1e3 * drawn.side(place, right), MARK, _MARK_WIDTH)
            case "pulleys":
                for end in drawn.ends[place : place + 2].reshape(-1, 2):
                    _disc(axes, name, end, 2.6 * float(arm.r[place]))
            case "bar":
                _way(axes, name, 1e3 * drawn.ends[place], MARK, 1.6 * _MARK_WIDTH)
            case "tip":
                _disc(axes, name, drawn.ends[-1].mean(axis=0), 0.3 * float(arm.b[-1]))
            case "base":
                _way(axes, name, 1e3 * 1.5 * drawn.ends[0], MARK, 1.6 * _MARK_WIDTH)
            case _:  # the camera, or another thing that is no part of the arm
                pass


def _way(axes: RecordedAxes, name: str, points: Array, colour: str, width: float) -> None:
    axes.plot(*points.T, color=colour, linewidth=width, solid_capstyle="round")
    axes.record(name, "outline", x=points[:, 0], y=points[:, 1])


def _ring(middle: Array, radius: float) -> Array:
    turn = np.linspace(0, 2 * np.pi, 25)
    return 1e3 * (middle + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1))


def _circle(axes: RecordedAxes, name: str, middle: Array, radius: float, colour: str) -> None:
    points = _ring(middle, radius)
    axes.fill(*points.T, facecolor="white", edgecolor=colour, linewidth=1.1, zorder=3)
    axes.record(name, "outline", x=points[:, 0], y=points[:, 1])


def _disc(axes: RecordedAxes, name: str, middle: Array, radius: float) -> None:
    points = _ring(middle, radius)
    axes.fill(*points.T, color=MARK, linewidth=0, zorder=1)
    axes.record(name, "outline", x=points[:, 0], y=points[:, 1])
