"""The arm in a pose, as it is drawn: points of its bars, its motors' drums, and the marks that all drawings of it share."""

from dataclasses import dataclass

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.cable_path import bar_ends
from mechanism.description import SIDE_OF
from mechanism.geometry import poses
from xneck.report import style
from xneck.report.recorded_axes import RecordedAxes

_BARS, _PULLEYS = "#555555", "#777777"
_DRUM_SHARE = 0.22
"""of a bar: what a drum is drawn with, larger than it is, so that its number can be read"""


@dataclass(frozen=True)
class DrawnArm:
    """Points of an arm, m; bars 0..N from the base up."""

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
        right = SIDE_OF[route[0]] == "right"
        beside = np.array([(j - (self.arm.M - 1) / 2) * 0.5 * float(self.arm.r[0]), 0.0])
        way = [self.drums[j] - beside, self.ends[0, int(right)]]
        for i, word in enumerate(route):
            right = SIDE_OF[word] == "right"
            if word.startswith("strut"):  # by the diagonal to the other side, and back along the top bar
                way.append(self.ends[i + 1, int(not right)])
            way.append(self.ends[i + 1, int(right)])
        return np.array(way) + beside


def drawn_arm(arm: Arm, alpha: Array | None = None) -> DrawnArm:
    """The arm at joint angles alpha (N,), rad, or straight."""
    ends = bar_ends(arm, poses(arm, np.zeros(arm.N) if alpha is None else alpha))
    radius = min(_DRUM_SHARE * float(arm.b[0]), 2 * float(arm.L[0]) / arm.M)
    # drums in the order of the sides on which their cables go up, so that no cable crosses another below the base
    order = np.argsort([SIDE_OF[route[0]] == "right" for route in arm.routes], kind="stable")
    x = np.empty(arm.M)
    x[order] = (np.arange(arm.M) - (arm.M - 1) / 2) * 2.6 * radius
    drums = np.stack([x, np.full(arm.M, -0.6 * float(arm.L[0]))], axis=-1)
    return DrawnArm(arm, np.stack([ends.real, ends.imag], axis=-1).astype(float), drums, radius)


def draw_bars(axes: RecordedAxes, drawn: DrawnArm) -> None:
    """Bars, pulleys and diagonals."""
    arm = drawn.arm
    for i, (left, right) in enumerate(drawn.ends):
        draw_way(axes, f"bar {i}", 1e3 * np.array([left, right]), _BARS, 2.6)
        for end in (left, right):
            draw_circle(axes, "pulley", end, float(arm.r[min(i, arm.N - 1)]), _PULLEYS)
    for i in range(arm.N):
        (a, b), (c, d) = drawn.ends[i], drawn.ends[i + 1]
        for ends in ((a, d), (b, c)):
            draw_way(axes, f"diagonal of mechanism {i + 1}", 1e3 * np.array(ends), _BARS, 1.6)


def draw_drums(axes: RecordedAxes, drawn: DrawnArm) -> None:
    """The motors' drums with their numbers, each in its cable's colour."""
    for j, middle in enumerate(drawn.drums):
        draw_circle(axes, f"drum {j + 1}", middle, drawn.drum_radius, style.cable_colour(j))
        x, y = 1e3 * middle
        axes.text(x, y, str(j + 1), ha="center", va="center_baseline", fontsize=7.5, color=style.MEASURED, zorder=4)


def name_joints(axes: RecordedAxes, drawn: DrawnArm) -> None:
    """The joints' numbers, to the right of them."""
    for i in range(drawn.arm.N):
        x, y = 1e3 * drawn.joint(i)
        right = x + 0.9e3 * drawn.arm.b[i]
        axes.text(right, y, f"joint {i + 1}", va="center", fontsize=8.0, color=style.joint_colour(i))


def draw_way(axes: RecordedAxes, name: str, points: Array, colour: str, width: float) -> None:
    """A line through points (P, 2), mm."""
    axes.plot(*points.T, color=colour, linewidth=width, solid_capstyle="round")
    axes.record(name, "outline", x=points[:, 0], y=points[:, 1])


def ring(middle: Array, radius: float) -> Array:
    """Points of a circle, mm; middle (2,) and radius in m."""
    turn = np.linspace(0, 2 * np.pi, 25)
    return 1e3 * (middle + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1))


def draw_circle(axes: RecordedAxes, name: str, middle: Array, radius: float, colour: str) -> None:
    """A circle that hides what is behind it; middle (2,) and radius in m."""
    points = ring(middle, radius)
    axes.fill(*points.T, facecolor="white", edgecolor=colour, linewidth=1.1, zorder=3)
    axes.record(name, "outline", x=points[:, 0], y=points[:, 1])
