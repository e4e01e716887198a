"""The arm as neck.yaml describes it, on one sheet, to be checked with one's eyes: the drawing, and its numbers beside it."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from mechanism.arm import Arm, Array, arm_of
from mechanism.cable_path import cable_contacts, path_points
from mechanism.description import SIDE_OF, Neck
from mechanism.geometry import check_angles, poses
from mechanism.printed_markers import BarMarker
from xneck.report import style
from xneck.report.arm_drawing import DrawnArm, draw_bars, draw_drums, draw_way, drawn_arm, name_joints
from xneck.report.description_text import (
    MAX_NAMED,
    cable_lines,
    gravity_line,
    marker_lines,
    mechanism_lines,
    motor_lines,
)
from xneck.report.recorded_axes import RecordedAxes
from xneck_foundation.authorship import MARK
from xneck_foundation.errors import one_of
from xneck_foundation.whole_file import whole_file

SUFFIXES = ("svg", "png", "pdf")
_METADATA = {
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
    "png": {"Software": MARK},
}
_DRAWING_WIDTH, _LEGEND_WIDTH, _LEAST_HEIGHT, _GREATEST_HEIGHT = 5.4, 5.6, 5.5, 14.0
"""in"""
_LINE = 0.185
"""in, height of a line of the legend"""
_SPRING = "#9DB8A0"
_GAP_SHARE = 0.35
"""of a pulley's radius, by which cables on one pulley are drawn apart"""
_PLAIN_GAP = 0.02
"""the same where pulleys have no radius, of a bar"""


def write_arm_sheet(neck: Neck, alpha: Array, path: Path, title: str) -> None:
    """Writes the sheet as .svg, .png or .pdf; alpha (N,), rad. Raises Refused for another suffix, or a pose that cannot be."""
    suffix = one_of(path, path.suffix.removeprefix(".").lower(), SUFFIXES, "suffix")
    check_angles(arm_of(neck), alpha)
    with style.drawing(), whole_file(path) as part:
        figure = arm_sheet(neck, alpha, title)
        figure.savefig(part, format=suffix, dpi=150, facecolor="white", metadata=_METADATA[suffix])


def arm_sheet(neck: Neck, alpha: Array, title: str) -> Figure:
    """The sheet as a figure; alpha (N,), rad."""
    drawn = drawn_arm(arm_of(neck), alpha)
    box = _box(drawn)
    legend = list(_legend(neck, alpha))
    tall = _DRAWING_WIDTH * (box.height / box.width)
    height = float(np.clip(max(tall, _LINE * (len(legend) + 3)), _LEAST_HEIGHT, _GREATEST_HEIGHT))
    width = _DRAWING_WIDTH + _LEGEND_WIDTH
    figure = Figure(figsize=(width, height))
    place = 0.7 / width, 0.5 / height, (_DRAWING_WIDTH - 0.8) / width, 1 - 0.9 / height
    axes = RecordedAxes(figure, place)
    _draw(axes, neck, drawn, alpha)
    axes.set_title(title)
    axes.set_aspect("equal", adjustable="box")
    box = box.shaped(place[2] * width / (place[3] * height))
    axes.set_xlim(1e3 * box.left, 1e3 * box.right)
    axes.set_ylim(1e3 * box.low, 1e3 * box.high)
    _draw_gravity(axes, neck, box)
    axes.set_xlabel("mm to the right")
    axes.set_ylabel("mm above the base")
    axes.grid(visible=False)
    y = height - 0.3
    for line, weight, colour in legend:
        if colour is not None:
            figure.text((_DRAWING_WIDTH + 0.12) / width, y / height, "▬", color=colour, fontsize=9, va="top")
        x = _DRAWING_WIDTH + (0.32 if colour is not None else 0.12)
        figure.text(x / width, y / height, line, fontsize=8.5, fontweight=weight, va="top", color=style.MEASURED)
        y -= _LINE
    return figure


@dataclass(frozen=True)
class _Box:
    """What is drawn lies within it, m."""

    left: float
    right: float
    low: float
    high: float

    @property
    def width(self) -> float:
        return self.right - self.left

    @property
    def height(self) -> float:
        return self.high - self.low

    def shaped(self, ratio: float) -> "_Box":
        """Made wider or higher about its middle, so that its width is `ratio` of its height."""
        wider, higher = max(ratio * self.height - self.width, 0) / 2, max(self.width / ratio - self.height, 0) / 2
        return _Box(self.left - wider, self.right + wider, self.low - higher, self.high + higher)


def _box(drawn: DrawnArm) -> _Box:
    points = np.vstack([drawn.ends.reshape(-1, 2), drawn.drums])
    margin = 0.6 * float(drawn.arm.b.max()) + drawn.drum_radius
    (left, low), (right, high) = points.min(axis=0) - margin, points.max(axis=0) + margin
    return _Box(float(left), float(right) + margin, float(low), float(high))


def _legend(neck: Neck, alpha: Array) -> Iterator[tuple[str, str, str | None]]:
    """Lines of the legend: text, weight, and the colour of the cable that a line is about."""
    if np.any(alpha):
        yield (
            f"joint angles {', '.join(f'{a:.3g}' for a in np.degrees(alpha))} deg, positive counter-clockwise",
            "normal",
            None,
        )
    yield gravity_line(neck), "normal", None
    for head, lines in (("mechanisms, from the base up", mechanism_lines(neck)), ("motors", motor_lines(neck))):
        yield head, "bold", None
        for line in lines:
            yield line, "normal", None
    yield "cables, in the order of the motors", "bold", None
    cables = cable_lines(neck)
    for j, line in enumerate(cables):
        yield line, "normal", style.cable_colour(j) if j < MAX_NAMED else None
    yield "markers", "bold", None
    for line in marker_lines(neck):
        yield line, "normal", None
    yield "how it is drawn", "bold", None
    yield "springs are green; cables on one pulley are drawn apart;", "normal", None
    yield "drums stand where there is room; bold is a marker's upper edge", "normal", None


def _draw(axes: RecordedAxes, neck: Neck, drawn: DrawnArm, alpha: Array) -> None:
    for i in range(neck.N):
        for right in (0, 1):
            draw_way(axes, f"spring {i + 1} {('left', 'right')[right]}", 1e3 * _zigzag(drawn, i, right), _SPRING, 1.0)
    draw_bars(axes, drawn)
    for j, wider in enumerate(_apart(drawn.arm, alpha)):
        contacts = cable_contacts(drawn.arm, alpha, j, wider)
        points = path_points(contacts)
        way = np.stack([points.real, points.imag], axis=-1)
        colour = style.cable_colour(j)
        axes.plot(*(1e3 * np.stack([drawn.drums[j], way[0]])).T, color=colour, linewidth=1.0, dashes=(4, 2), zorder=2)
        axes.plot(*(1e3 * way).T, color=colour, linewidth=1.3, zorder=5, solid_joinstyle="round")
        axes.record(f"cable {j + 1}", "outline", x=1e3 * way[:, 0], y=1e3 * way[:, 1])
        axes.plot(*(1e3 * way[-1]), "o", color=colour, markersize=max(2.5, 6.5 - 0.5 * j), zorder=5 + 0.01 * j)
    draw_drums(axes, drawn)
    name_joints(axes, drawn)
    for marker in neck.markers.on_bars if neck.markers else ():
        _draw_marker(axes, drawn.arm, alpha, marker, neck.markers.size if neck.markers else 0.0)


def _draw_gravity(axes: RecordedAxes, neck: Neck, box: _Box) -> None:
    """An arrow along gravity, in the upper left corner of the drawing."""
    pull = np.array(neck.gravity)
    size = float(np.linalg.norm(pull))
    if size == 0:
        return
    span = 0.1 * min(box.width, box.height)
    middle = np.array([box.left + 0.8 * span, box.high - 0.8 * span])
    begin, end = (1e3 * (middle + side * span / 2 * pull / size) for side in (-1, 1))
    arrow = {"arrowstyle": "-|>", "color": style.MUTED, "linewidth": 1.2}
    axes.annotate("", xy=tuple(end), xytext=tuple(begin), arrowprops=arrow)
    x, y = 1e3 * middle
    axes.text(x + 250 * span, y, "g", color=style.MUTED, va="center")


def _apart(arm: Arm, alpha: Array) -> Array:
    """m, by which each cable is drawn outside of its pulleys, (M,): those of one side one by one, as far as there is room."""
    right = np.array([SIDE_OF[route[0]] == "right" for route in arm.routes])
    rank = np.where(right, np.cumsum(right), np.cumsum(~right)) - 1.0
    gap = np.where(arm.r > 0, _GAP_SHARE * arm.r, _PLAIN_GAP * arm.b).min()
    ends = drawn_arm(arm, alpha).ends
    sides = np.linalg.norm(np.diff(ends, axis=0), axis=-1)
    room = 0.9 * min(float(sides.min()), float(arm.b.min()) / 2, float(arm.L.min()) / 2) - float(arm.r.max())
    return rank * min(float(gap), max(room, 0.0) / max(float(rank.max()), 1.0))


def _zigzag(drawn: DrawnArm, mechanism: int, right: int) -> Array:
    """A spring between the ends of two bars, (P, 2), m."""
    low, high = drawn.side(mechanism, right)
    along = high - low
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along) * 0.07 * float(drawn.arm.b[mechanism])
    turns = 16
    share = np.r_[0.0, 0.12, np.linspace(0.14, 0.86, turns), 0.88, 1.0]
    swing = np.r_[0.0, 0.0, np.tile([1.0, -1.0], turns // 2), 0.0, 0.0]
    return low + share[:, None] * along + swing[:, None] * across


def _draw_marker(axes: RecordedAxes, arm: Arm, alpha: Array, marker: BarMarker, size: float) -> None:
    """The black square of a marker where it sits, with its id, and a line along its upper edge."""
    pose = poses(arm, alpha)
    if marker.mechanism is None:
        assert marker.bar is not None
        middle, turn = pose.bar_middle[marker.bar], pose.bar_angle[marker.bar]
    else:
        which = marker.mechanism - 1, "AB".index(str(marker.diagonal)[0])
        middle, turn = pose.diagonal_middle[which], pose.diagonal_angle[which]
    centre = middle + complex(*marker.at) * np.exp(1j * turn)
    corners = size / 2 * np.array([-1 + 1j, 1 + 1j, 1 - 1j, -1 - 1j]) * np.exp(1j * (turn + marker.angle)) + centre
    points = 1e3 * np.stack([corners.real, corners.imag], axis=-1)
    name = f"marker {marker.id}"
    axes.fill(*points.T, facecolor="#FFFFFFD8", edgecolor=style.MEASURED, linewidth=0.8, zorder=4)
    axes.record(name, "outline", x=points[:, 0], y=points[:, 1])
    axes.plot(*points[:2].T, color=style.MEASURED, linewidth=2.2, zorder=4)
    axes.text(
        1e3 * centre.real, 1e3 * centre.imag, str(marker.id), ha="center", va="center_baseline", fontsize=8, zorder=7
    )
