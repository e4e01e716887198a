"""Boards and markers on paper at true scale, as PDF or SVG, each sheet with a ruler that shows whether the print is.

Everything is drawn in millimetres from the sheet's lower left corner, as outlines without joints between cells, so that
neither a viewer's anti-aliasing nor a printer's resolution leaves hairlines.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from calibration.board import AprilGrid, Board, Charuco
from calibration.dictionaries import is_upside_down, marker_cells
from xneck_foundation.errors import Refused, one_of
from xneck_foundation.whole_file import whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PAPERS_MM = {"A4": (210.0, 297.0), "A3": (297.0, 420.0)}
_MARGIN_MM = 10.0
"""what printers cannot reach"""
_FOOT_MM = 27.0
"""height of the ruler and its text"""


@dataclass(frozen=True)
class _Marker:
    """One marker on a page: its lower left corner and side, mm."""

    marker_id: int
    x: float
    y: float
    side: float


def board_sheet(board: Board, out: str | Path) -> tuple[float, float]:
    """Draw `board` on one sheet, the smallest of A4, A3 or a sheet of its own size. Returns the sheet's size, mm.

    Raises Refused where `out` does not end in .pdf or .svg, or cannot be written.
    """
    _suffix(out)
    width, height = 1e3 * board.size[0], 1e3 * board.size[1]
    quiet = min(1e3 * board.square, _MARGIN_MM)  # the board needs white around it to be found
    page = _paper(width + 2 * (_MARGIN_MM + quiet), height + 2 * quiet + _MARGIN_MM + _FOOT_MM)
    figure, axes = _blank(page)
    x0 = (page[0] - width) / 2
    y0 = _FOOT_MM + quiet + (page[1] - _FOOT_MM - _MARGIN_MM - 2 * quiet - height) / 2
    for cells, x, y, side in _drawing(board):
        _cells(axes, cells, x0 + 1e3 * x, y0 + height - 1e3 * (y + side), 1e3 * side)
    _foot(axes, page, board.title)
    _write([figure], out)
    return page


def marker_sheet(
    ids: Sequence[int], size_m: float, dictionary: str, out: str | Path, title: str = "Markers"
) -> tuple[int, tuple[float, float]]:
    """Draw markers with a black square of side `size_m`, m, in rows on as many sheets as it takes.

    Each is surrounded by white of one cell's width or more, with cutting marks, its id and an arrow along its x axis.
    Returns the number of sheets and their size, mm. Raises Refused for an unknown dictionary or id, a size that no
    printer makes, a list without markers or with one twice, and an SVG (one sheet) on which they do not fit.
    """
    suffix = _suffix(out)
    if not ids:
        raise Refused(out, "no markers to draw")
    if len(set(ids)) != len(ids):
        raise Refused(out, "a marker stands twice in the list", "each id once")
    if not 0.002 <= size_m <= 0.5:
        raise Refused(out, f"a marker of {size_m:g} m", "from 0.002 to 0.5 m")
    side = 1e3 * size_m
    quiet = max(side / (marker_cells(dictionary, ids[0]).shape[0]), 2.0)
    box_width, box_height = side + 2 * quiet, side + 2 * quiet + 6.0  # mm, with the text below
    page = _paper(box_width + 2 * _MARGIN_MM, box_height + _FOOT_MM + _MARGIN_MM)
    columns = int((page[0] - 2 * _MARGIN_MM + 4.0) // (box_width + 4.0))
    rows = int((page[1] - _MARGIN_MM - _FOOT_MM + 2.0) // (box_height + 2.0))
    per_page = columns * rows
    sheets = [ids[i : i + per_page] for i in range(0, len(ids), per_page)]
    if suffix == ".svg" and len(sheets) > 1:
        raise Refused(out, f"{len(ids)} markers need {len(sheets)} sheets and an SVG has one", "write a .pdf")
    figures: list[Figure] = []
    for number, sheet in enumerate(sheets, start=1):
        figure, axes = _blank(page)
        for place, marker_id in enumerate(sheet):
            x = _MARGIN_MM + (place % columns) * (box_width + 4.0)
            y = page[1] - _MARGIN_MM - (place // columns) * (box_height + 2.0) - box_width
            _cutting_marks(axes, x, y, box_width)
            _labelled(axes, dictionary, _Marker(marker_id, x + quiet, y + quiet, side), y)
        of = f", sheet {number} of {len(sheets)}" if len(sheets) > 1 else ""
        _foot(axes, page, f"{title}: {dictionary}, black squares of {side:g} mm{of}")
        figures.append(figure)
    _write(figures, out)
    return len(sheets), page


def cell_outlines(cells: np.ndarray) -> list[np.ndarray]:
    """Closed outlines of the True cells of a grid: arrays (n, 2) of (column, row) corners, black on the left hand.

    Drawn together with the non-zero rule they fill exactly the True cells (holes run the other way round).
    """
    edges: dict[tuple[int, int], list[tuple[int, int]]] = {}
    padded = np.pad(cells, 1)
    for row, column in np.argwhere(cells):
        around = padded[row : row + 3, column : column + 3]
        c, r = int(column), int(row)
        for black, start, end in (
            (around[0, 1], (c, r), (c + 1, r)),
            (around[1, 2], (c + 1, r), (c + 1, r + 1)),
            (around[2, 1], (c + 1, r + 1), (c, r + 1)),
            (around[1, 0], (c, r + 1), (c, r)),
        ):
            if not black:
                edges.setdefault(start, []).append(end)
    loops: list[np.ndarray] = []
    while edges:
        start = next(iter(edges))
        loop = [start]
        while True:
            ends = edges[loop[-1]]
            end = ends.pop()
            if not ends:
                del edges[loop[-1]]
            if end == start:
                break
            loop.append(end)
        loops.append(np.array(loop))
    return loops


def _drawing(board: Board) -> Iterator[tuple[np.ndarray, float, float, float]]:
    """Black cells, and x, y (down) and side of their square, m, from the drawing's upper left corner."""
    black = np.ones((1, 1), bool)
    if isinstance(board, AprilGrid):
        for index in range(board.columns * board.rows):
            cells = marker_cells(board.dictionary, board.first_id + index, border=2)
            x, y = board.tag_place(index)
            yield np.rot90(cells, 2 * is_upside_down(board.dictionary)), x + board.square, y + board.square, board.tag
        pitch = board.tag + board.square
        for row in range(board.rows + 1):
            for column in range(board.columns + 1):
                yield black, column * pitch, row * pitch, board.square
        return
    with_marker: set[tuple[int, int]] = set()
    columns, rows = board.columns + 1, board.rows + 1
    if isinstance(board, Charuco):
        columns, rows = board.columns, board.rows
        pattern = board.opencv()
        for marker_id, corners in zip(np.ravel(pattern.getIds()), pattern.getObjPoints(), strict=True):
            x, y = np.mean(np.reshape(corners, (4, 3)), axis=0)[:2]
            with_marker.add((int(x // board.square), int(y // board.square)))
            cells = marker_cells(board.dictionary, int(marker_id))
            yield cells, x - board.marker / 2, y - board.marker / 2, board.marker
    for row in range(rows):
        for column in range(columns):
            white = (column, row) in with_marker if with_marker else (column + row) % 2 == 1
            if not white:
                yield black, column * board.square, row * board.square, board.square


def _cells(axes: "Axes", cells: np.ndarray, x: float, y: float, side: float) -> None:
    """Black cells as one compound path, lower left corner at (x, y), mm."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    cell = side / cells.shape[0]
    corners: list[tuple[float, float]] = []
    codes: list[int] = []
    for loop in cell_outlines(cells):
        points = [(x + cell * column, y + side - cell * row) for column, row in loop]
        corners += [*points, points[0]]
        codes += [int(Outline.MOVETO), *[int(Outline.LINETO)] * (len(points) - 1), int(Outline.CLOSEPOLY)]
    axes.add_patch(PathPatch(Outline(np.array(corners), np.array(codes, np.uint8)), facecolor="black", linewidth=0))


def _labelled(axes: "Axes", dictionary: str, marker: _Marker, floor: float) -> None:
    """A marker with its id and the direction of its x axis below, above `floor`, mm."""
    _cells(axes, marker_cells(dictionary, marker.marker_id), marker.x, marker.y, marker.side)
    axes.text(marker.x, floor - 1.0, f"id {marker.marker_id}", fontsize=6, va="top", ha="left", clip_on=False)
    axes.text(marker.x + marker.side, floor - 1.0, "x \N{RIGHTWARDS ARROW}", fontsize=6, va="top", ha="right")


def _cutting_marks(axes: "Axes", x: float, y: float, side: float) -> None:
    """Crosses at the corners of a square with its lower left corner at (x, y), mm."""
    for cx, cy in ((x, y), (x + side, y), (x, y + side), (x + side, y + side)):
        axes.plot([cx - 1, cx + 1], [cy, cy], color="0.6", linewidth=0.3)
        axes.plot([cx, cx], [cy - 1, cy + 1], color="0.6", linewidth=0.3)


def _foot(axes: "Axes", page: tuple[float, float], title: str) -> None:
    """A ruler as long as the sheet allows, in whole centimetres, and the sheet's title."""
    length = 10 * int(min(200.0, page[0] - 2 * _MARGIN_MM - 5.0) // 10)
    x0, y0 = _MARGIN_MM, _MARGIN_MM + 4.0
    axes.plot([x0, x0 + length], [y0, y0], color="black", linewidth=0.4, solid_capstyle="butt", gid="ruler")
    for mm in range(length + 1):
        tick = 4.0 if mm % 10 == 0 else (2.5 if mm % 5 == 0 else 1.5)
        axes.plot([x0 + mm, x0 + mm], [y0, y0 + tick], color="black", linewidth=0.3, solid_capstyle="butt")
        if mm % 10 == 0:
            axes.text(x0 + mm, y0 + 4.5, str(mm), fontsize=5, ha="center", va="bottom")
    text = f"Print at 100 % (actual size). This ruler must measure {length} mm, otherwise scale the sizes in the file."
    axes.text(x0, y0 - 1.5, text, fontsize=min(6.5, 0.033 * page[0]), va="top", ha="left")
    axes.text(x0, y0 + 8.5, title, fontsize=min(7.0, 0.033 * page[0]), va="bottom", ha="left")


def _paper(width: float, height: float) -> tuple[float, float]:
    """The smallest paper, upright or not, that holds width x height, mm; a sheet of that size where none does."""
    for paper in _PAPERS_MM.values():
        for page in (paper, paper[::-1]):
            if width <= page[0] and height <= page[1]:
                return page[0], page[1]
    return max(width, 60.0), height


def _blank(page: tuple[float, float]) -> tuple["Figure", "Axes"]:
    """A white sheet whose data coordinates are millimetres."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(page[0] / 25.4, page[1] / 25.4))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, page[0])
    axes.set_ylim(0.0, page[1])
    axes.axis("off")
    return figure, axes


def _suffix(out: str | Path) -> str:
    return one_of(out, Path(out).suffix.lower(), [".pdf", ".svg"], "kind of sheet")


def _write(figures: "list[Figure]", out: str | Path) -> None:
    import matplotlib
    from matplotlib.backends.backend_pdf import PdfPages

    # no dates and fixed ids: the same board gives the same file
    with matplotlib.rc_context({"svg.hashsalt": "xneck", "pdf.fonttype": 42}), whole_file(out) as part:
        if _suffix(out) == ".svg":
            figures[0].savefig(part, format="svg", metadata={"Date": None})
        else:
            with PdfPages(part, metadata={"CreationDate": None}) as pages:
                for figure in figures:
                    pages.savefig(figure)
