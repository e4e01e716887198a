"""What the arm looks like: flat shapes in the plane of motion, from back to front, and how they are painted.

Shapes are for people. What is measured in the pictures, the markers, is not painted but sampled (`printed.py`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from samples.generator import linkage
from samples.generator.camera import Camera
from samples.generator.routes import cable_outlines

Colour = tuple[float, float, float]
Complex = NDArray[np.complexfloating[Any, Any]]

STEEL: Colour = (0.50, 0.52, 0.55)
ALUMINIUM: Colour = (0.66, 0.67, 0.68)
SHADED: Colour = (0.40, 0.42, 0.45)
ANODISED: Colour = (0.10, 0.14, 0.22)
EDGE: Colour = (0.07, 0.07, 0.08)
NYLON: Colour = (0.72, 0.70, 0.62)
BRASS: Colour = (0.60, 0.44, 0.14)
TABLE: Colour = (0.24, 0.20, 0.17)
CABLES: tuple[Colour, ...] = ((0.85, 0.12, 0.10), (0.95, 0.58, 0.05), (0.10, 0.58, 0.20), (0.10, 0.30, 0.85))
LAYER = 0.0025
"""Cables share the pulleys side by side: each runs this much behind the one before, m, and so is seen apart from it."""


@dataclass(frozen=True)
class Shape:
    """A filled outline or a stroke, in the plane of motion."""

    points: Complex
    """shape (n,), m; x + iy"""
    colour: Colour
    """reflectance of red, green, blue"""
    stroke: float = 0.0
    """width, m; 0 fills the outline"""
    depth: float = 0.0
    """how far behind the plane of the markers, m"""


def arm(alpha: NDArray[np.float64], neck: dict[str, Any], payload: bool = True) -> list[Shape]:
    """What moves, at joint angles `alpha`, shape (N,), rad, from back to front, without the markers."""
    L, b, r = (np.array([float(m[key]) for m in neck["mechanisms"]]) for key in ("L", "b", "r"))
    bars = linkage.solve(alpha, L, b)
    n = len(L)
    shapes = _weight(bars.middle[n], float(bars.orientation[n])) if payload else []
    for i in range(1, n + 1):
        for ends in (bars.left, bars.right):
            shapes += _spring(ends[i - 1], ends[i], 0.8 * float(r[i - 1]))
    for i in range(1, n + 1):
        shapes += _rod(bars.right[i - 1], bars.left[i], 0.0042, SHADED)
        shapes += _rod(bars.left[i - 1], bars.right[i], 0.0042, ALUMINIUM)
    for i in range(n + 1):
        shapes += _rod(bars.left[i], bars.right[i], 0.0052, ANODISED)
    wheels = [(end[i], float(r[min(i, n - 1)])) for i in range(n + 1) for end in (bars.left, bars.right)]
    for centre, radius in wheels:
        shapes.append(Shape(_disc(centre, radius + 0.0003), EDGE, depth=(len(neck["cables"]) + 1) * LAYER))
    for layer, line in reversed(list(enumerate(cable_outlines(neck, np.asarray(alpha)), start=1))):
        line = np.append(complex(0.0, line[0].imag), line)  # it comes from behind the base marker
        colour = CABLES[(layer - 1) % len(CABLES)]
        shapes += [Shape(line, EDGE, 0.0017, layer * LAYER), Shape(line, colour, 0.0012, layer * LAYER)]
    for k, (centre, radius) in enumerate(wheels):
        shapes += _pulley(centre, radius, float(bars.orientation[k // 2]))
    return shapes


def paint(
    canvas: NDArray[np.uint8], shapes: Sequence[Shape], camera: Camera, origin: tuple[int, int], zoom: int
) -> None:
    """Paint shapes into `canvas`, shape (zoom h, zoom w, 3), which begins with the camera's pixel `origin`."""
    places = np.cumsum([0] + [len(s.points) for s in shapes])
    pixels = _project(shapes, camera) - origin
    # centre of pixel u lies at zoom u + (zoom - 1) / 2 of the finer raster; OpenCV takes 1/16 px
    fixed = np.rint((pixels * zoom + (zoom - 1) / 2) * 16).astype(np.int32)
    scale = zoom * camera.fx / camera.translation[2]
    for shape, first, last in zip(shapes, places[:-1], places[1:], strict=True):
        ink = tuple(255 * c for c in shape.colour)
        if shape.stroke:
            wide = max(1, round(shape.stroke * scale))
            cv2.polylines(canvas, [fixed[first:last]], False, ink, wide, cv2.LINE_AA, 4)
        else:
            cv2.fillPoly(canvas, [fixed[first:last]], ink, cv2.LINE_AA, 4)


def base(b: float) -> list[Shape]:
    """What never moves: the table top and the pedestal under bar 0 of length b, m."""
    foot = b / 2 + 0.014
    table = Shape(_box(-0.6, -0.2, 0.6, -0.0275), TABLE)
    rim = Shape(_box(-0.6, -0.0300, 0.6, -0.0275), (0.36, 0.31, 0.26))
    block = Shape(_box(-foot, -0.0275, foot, -0.0080), SHADED)
    top = Shape(_box(-foot, -0.0105, foot, -0.0080), STEEL)
    bolts = [Shape(_disc(complex(x, -0.0190), 0.0025), EDGE) for x in (-foot + 0.006, foot - 0.006)]
    return [table, rim, block, top, *bolts]


def _weight(middle: complex, angle: float) -> list[Shape]:
    """A brass weight that was left clamped behind the top plate."""
    turn = np.exp(1j * angle)
    block = middle + turn * _box(-0.0165, 0.004, 0.0165, 0.0290)
    shine = middle + turn * _box(-0.0120, 0.004, -0.0075, 0.0290)
    knob = middle + turn * _box(-0.0040, 0.0290, 0.0040, 0.0325)
    return [Shape(knob, STEEL), Shape(block, BRASS), Shape(shine, (0.78, 0.62, 0.28)), _contour(block), _contour(knob)]


def _spring(a: complex, b: complex, radius: float, turns: int = 8) -> list[Shape]:
    """A coil spring between two points: a zig-zag between straight hooks."""
    along = (b - a) / abs(b - a)
    s = np.concatenate([[0.0, 0.2], 0.2 + 0.6 * (np.arange(2 * turns) + 0.5) / (2 * turns), [0.8, 1.0]])
    side = np.zeros(len(s))
    side[2:-2] = radius * (-1.0) ** np.arange(2 * turns)
    line = a + s * (b - a) + 1j * along * side
    return [Shape(line, (0.11, 0.11, 0.12), 0.0019), Shape(line, (0.74, 0.75, 0.76), 0.0010)]


def _rod(a: complex, b: complex, half: float, colour: Colour) -> list[Shape]:
    """A flat bar with round ends, its edges and a streak of light."""
    along = (b - a) / abs(b - a)
    arc = np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 9)) * half * along
    s = np.linspace(0, 1, 5)[1:-1]  # the lens bends long edges
    offset = 1j * along * half
    outline = np.concatenate([b + arc, b + offset + s * (a - b), a - arc, a - offset + s * (b - a)])
    streak = np.array([a + 0.45 * offset, b + 0.45 * offset])
    lighter = (min(1.0, 1.35 * colour[0]), min(1.0, 1.35 * colour[1]), min(1.0, 1.35 * colour[2]))
    return [Shape(outline, colour), Shape(streak, lighter, 0.0010), _contour(outline)]


def _pulley(centre: complex, r: float, angle: float) -> list[Shape]:
    """A disc whose rim stands over the cable's groove, with a hub and a mark that shows its bar's turning."""
    mark = centre + np.exp(1j * angle) * np.array([0.45, 0.85]) * r
    rim = _disc(centre, r + 0.0003)
    hub = _disc(centre, 0.35 * r)
    return [Shape(rim, NYLON), _contour(rim), Shape(hub, STEEL), _contour(hub), Shape(mark, EDGE, 0.0008)]


def _contour(outline: Complex) -> Shape:
    return Shape(np.append(outline, outline[0]), EDGE, 0.0005)


def _disc(centre: complex, radius: float, count: int = 28) -> Complex:
    return centre + radius * np.exp(2j * np.pi * np.arange(count) / count)


def _box(left: float, bottom: float, right: float, top: float) -> Complex:
    """Outline of a rectangle with points along its long sides, because the lens bends them."""
    s = np.linspace(0, 1, 24)
    below, above = left + s * (right - left) + 1j * bottom, right + s * (left - right) + 1j * top
    return np.concatenate([below, above])


def _project(shapes: Sequence[Shape], camera: Camera) -> NDArray[np.float64]:
    """Pixels of all points of all shapes, shape (sum of n, 2)."""
    points = np.concatenate([s.points for s in shapes])
    depth = np.repeat([s.depth for s in shapes], [len(s.points) for s in shapes])
    return camera.project(np.stack([points.real, points.imag, -depth], axis=-1))


def reach(shapes: Sequence[Shape], camera: Camera, margin: int = 6) -> tuple[int, int, int, int]:
    """Pixels that the shapes may touch: left, top, right, bottom, the last two exclusive, within the picture."""
    pixels = _project(shapes, camera)
    left, top = np.floor(pixels.min(axis=0)).astype(int) - margin
    right, bottom = np.ceil(pixels.max(axis=0)).astype(int) + margin + 1
    return max(0, int(left)), max(0, int(top)), min(camera.width, int(right)), min(camera.height, int(bottom))
