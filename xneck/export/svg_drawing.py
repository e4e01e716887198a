"""A panel of a page, which is SVG as matplotlib and the page's legends write it, drawn again as a matplotlib figure.

What is understood is what these write: paths, uses of a path, rectangles and circles, texts, and clipping by a rectangle.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from xml.etree.ElementTree import Element, fromstring

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

Array = NDArray[np.float64]
_POINTS_PER_INCH = 72.0
_TOKENS = re.compile(r"[MLCQHzZ]|-?\d+(?:\.\d+)?(?:e-?\d+)?")
_CODES = {"M": (Path.MOVETO, 1), "L": (Path.LINETO, 1), "Q": (Path.CURVE3, 2), "C": (Path.CURVE4, 3)}
"""code and number of points of a path's commands"""
_ALIGNMENTS = {"start": "left", "middle": "center", "end": "right"}
_SWATCH = (28.0, 12.0)
"""of a legend, in the units of its own picture"""
_ROW_PT, _LETTER_PT, _TEXT_PT = 13.0, 4.7, 8.0
"""height of a legend's row, width that a letter is given, size of its text"""


@dataclass(frozen=True)
class _Within:
    """What an element takes from those around it: where it is drawn, and what it is cut to."""

    style: Mapping[str, str]
    move: Affine2D
    clip: Rectangle | None


def redrawn(svgs: Sequence[str], legend: Sequence[tuple[str, str]] = ()) -> Figure:
    """Panels one under another as a figure of their size, 1 unit a point; legend: swatch (SVG) and words of each entry, below."""
    roots = [_parsed(svg) for svg in svgs]
    sizes = [[float(number) for number in root.attrib["viewBox"].split()[2:]] for root in roots]
    width, height = max(w for w, _ in sizes), sum(h for _, h in sizes)
    rows = _legend_rows([words for _, words in legend], width)
    total = height + _ROW_PT * (max(row for row, _ in rows) + 1) + 4 if rows else height
    figure = Figure(figsize=(width / _POINTS_PER_INCH, total / _POINTS_PER_INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0, width)
    axes.set_ylim(total, 0)
    axes.axis("off")
    top = 0.0
    for root, (_, h) in zip(roots, sizes, strict=True):
        _draw(axes, root, Affine2D().translate(0, top))
        top += h
    for (swatch, words), (row, x) in zip(legend, rows, strict=True):
        y = height + _ROW_PT * row
        _draw(axes, _parsed(swatch), Affine2D().scale(0.8).translate(x, y))
        axes.text(x + 0.8 * _SWATCH[0] + 4, y + 0.65 * _SWATCH[1], words, fontsize=_TEXT_PT, va="baseline")
    return figure


def _parsed(svg: str) -> Element:
    return fromstring(svg.replace("xlink:href", "href"))


def _legend_rows(words: list[str], width: float) -> list[tuple[int, float]]:
    """Row and left edge of each entry, one beside the other where there is room."""
    places, row, x = [], 0, 6.0
    for text in words:
        needed = _SWATCH[0] + 8 + _LETTER_PT * len(text)
        if x > 6.0 and x + needed > width:
            row, x = row + 1, 6.0
        places.append((row, x))
        x += needed
    return places


def _draw(axes: Axes, root: Element, move: Affine2D) -> None:
    named = {element.attrib["id"]: element for element in root.iter() if "id" in element.attrib}
    _draw_children(axes, root, _Within({}, move, None), named)


def _draw_children(axes: Axes, element: Element, within: _Within, named: Mapping[str, Element]) -> None:
    for part in element:
        inner = _within(axes, part, within, named)
        match part.tag:
            case "g":
                _draw_children(axes, part, inner, named)
            case "path":
                _draw_path(axes, _path(part.attrib["d"]), inner)
            case "rect":
                x, y, w, h = (float(part.attrib.get(key, 0)) for key in ("x", "y", "width", "height"))
                _draw_path(axes, Path([(x, y), (x + w, y), (x + w, y + h), (x, y + h), (x, y)], closed=True), inner)
            case "circle":
                x, y, r = (float(part.attrib[key]) for key in ("cx", "cy", "r"))
                _draw_path(axes, Path.circle((x, y), r), inner)
            case "use":
                used = named[part.attrib["href"].removeprefix("#")]
                x, y = (float(part.attrib.get(key, 0)) for key in ("x", "y"))
                moved = replace(
                    inner, move=Affine2D().translate(x, y) + inner.move, style={**inner.style, **_style(used)}
                )
                _draw_path(axes, _path(used.attrib["d"]), moved)
            case "text":
                _draw_text(axes, part, inner)


def _within(axes: Axes, element: Element, outer: _Within, named: Mapping[str, Element]) -> _Within:
    clip = outer.clip
    if "clip-path" in element.attrib:
        box = named[element.attrib["clip-path"].removeprefix("url(#").removesuffix(")")][0].attrib
        x, y, w, h = (float(box[key]) for key in ("x", "y", "width", "height"))
        clip = Rectangle((x, y), w, h, transform=outer.move + axes.transData)
    return replace(outer, style={**outer.style, **_style(element)}, clip=clip)


def _style(element: Element) -> dict[str, str]:
    """The element's own style, from its style and from attributes of the same names."""
    entries = (entry.partition(":") for entry in element.attrib.get("style", "").split(";") if entry.strip())
    plain = ("fill", "fill-opacity", "opacity", "stroke", "stroke-width", "stroke-dasharray")
    return {key: element.attrib[key] for key in plain if key in element.attrib} | {
        key.strip(): value.strip() for key, _, value in entries
    }


def _path(d: str) -> Path:
    """A path of absolute moves, lines and curves; H is a line along x."""
    vertices: list[tuple[float, float]] = []
    codes: list[int] = []
    tokens, at, command = _TOKENS.findall(d), 0, "M"
    while at < len(tokens):
        if tokens[at].isalpha():
            command, at = tokens[at], at + 1
        if command in "zZ":
            vertices.append(vertices[-1])
            codes.append(int(Path.CLOSEPOLY))
        elif command == "H":
            vertices.append((float(tokens[at]), vertices[-1][1]))
            codes.append(int(Path.LINETO))
            at += 1
        else:
            code, count = _CODES[command]
            numbers = [float(token) for token in tokens[at : at + 2 * count]]
            vertices += list(zip(numbers[::2], numbers[1::2], strict=True))
            codes += [int(code)] * count
            at += 2 * count
            command = "L" if command == "M" else command  # numbers that follow a move are lines
    return Path(np.array(vertices), codes)


def _draw_path(axes: Axes, path: Path, within: _Within) -> None:
    style = within.style
    whole = float(style.get("opacity", 1))

    def colour(key: str, default: str) -> tuple[float, ...] | str:
        value = style.get(key, default)
        return "none" if value == "none" else to_rgba(value, whole * float(style.get(f"{key}-opacity", 1)))

    width = float(style.get("stroke-width", 1))
    points = _points_of_dots(path)
    if points is not None:
        (drawn,) = axes.plot(*points.T, "o", markersize=width, markeredgewidth=0, color=colour("stroke", "none"))
        drawn.set_transform(within.move + axes.transData)
        drawn.set_clip_path(within.clip)
        return
    dashes = [float(part) for part in re.split(r"[ ,]+", style.get("stroke-dasharray", "")) if part]
    cap = {"square": "projecting", "round": "round"}.get(style.get("stroke-linecap", "butt"), "butt")
    patch = PathPatch(
        path,
        facecolor=colour("fill", "#000000"),
        edgecolor=colour("stroke", "none"),
        linewidth=width if style.get("stroke", "none") != "none" else 0.0,
        linestyle=(0, tuple(part / max(width, 1e-9) for part in dashes)) if dashes else "solid",
        capstyle=cap,  # type: ignore[arg-type]
        joinstyle="round",
        transform=within.move + axes.transData,
    )
    axes.add_artist(patch)
    patch.set_clip_path(within.clip)


def _points_of_dots(path: Path) -> Array | None:
    """The points (K, 2) of a path of lines without length, which round ends show as dots; None of any other path."""
    vertices, codes = np.asarray(path.vertices, dtype=float), np.asarray(path.codes).tolist()
    if path.codes is None or codes != [int(Path.MOVETO), int(Path.LINETO)] * (len(vertices) // 2):
        return None
    return vertices[::2] if np.array_equal(vertices[::2], vertices[1::2]) else None


def _draw_text(axes: Axes, element: Element, within: _Within) -> None:
    style = within.style
    turned = re.match(r"rotate\((-?[\d.]+)", element.attrib.get("transform", ""))
    x, y = within.move.transform((float(element.attrib["x"]), float(element.attrib["y"])))
    text = axes.text(
        x,
        y,
        "".join(element.itertext()),
        fontsize=float(style.get("font-size", "8px").removesuffix("px")),
        fontweight=int(style.get("font-weight", 400)),
        color=style.get("fill", "#000000"),
        ha=_ALIGNMENTS[style.get("text-anchor", "start")],
        va="baseline",
        rotation=-float(turned[1]) if turned else 0.0,
        rotation_mode="anchor",
        parse_math=False,
    )
    text.set_clip_on(False)
