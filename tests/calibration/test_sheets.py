"""The drawn sheets are read back and measured."""

import re
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import KDTree

from calibration.board import AprilGrid, Charuco, Chessboard
from calibration.dictionaries import marker_cells, opencv_dictionary
from calibration.sheets import board_sheet, cell_outlines, marker_sheet
from tests.calibration.truth import raster, svg_blacks
from xneck_foundation.errors import Refused

CHARUCO = Charuco(kind="charuco", columns=9, rows=6, square=0.025, marker=0.0175, dictionary="aruco_5x5_100")
CHESSBOARD = Chessboard(kind="chessboard", columns=9, rows=6, square=0.020)


def bounds(shapes: list[list[np.ndarray]]) -> np.ndarray:
    points = np.concatenate([loop for shape in shapes for loop in shape])
    return np.array([points.min(axis=0), points.max(axis=0)])


def pdf_strokes(path: Path) -> tuple[tuple[float, ...], str]:
    """Media box, mm, and all decompressed page content of a PDF."""
    content = path.read_bytes()
    box = re.search(rb"/MediaBox \[ ([\d. ]+)\]", content)
    assert box
    text = ""
    for stream in re.findall(rb"stream\r?\n(.*?)endstream", content, re.S):
        try:
            text += zlib.decompress(stream.strip(b"\r\n")).decode("latin-1")
        except zlib.error:
            continue
    return tuple(float(v) * 25.4 / 72 for v in box[1].split()), text


def test_charuco_svg_is_true_to_scale_and_detected(tmp_path: Path):
    out = tmp_path / "board.svg"
    page = board_sheet(CHARUCO, out)
    size, shapes = svg_blacks(out)
    np.testing.assert_allclose(size, page, atol=1e-3)
    low, high = bounds(shapes)
    np.testing.assert_allclose(high - low, [225.0, 150.0], atol=1e-3)  # mm
    texture = raster(size, shapes)
    corners, ids, *_ = cv2.aruco.CharucoDetector(CHARUCO.opencv()).detectBoard(texture)
    assert ids is not None
    assert len(ids) == 40
    # pixel i of the raster covers [i, i + 1] / 8 mm
    measured = (np.reshape(corners, (-1, 2)) + 0.5) / 8 - low
    np.testing.assert_allclose(measured, 1e3 * CHARUCO.corners[np.asarray(ids, int).ravel()][:, :2], atol=0.05)


def test_chessboard_svg_is_true_to_scale_and_found(tmp_path: Path):
    board_sheet(CHESSBOARD, tmp_path / "board.svg")
    size, shapes = svg_blacks(tmp_path / "board.svg")
    low, high = bounds(shapes)
    np.testing.assert_allclose(high - low, [200.0, 140.0], atol=1e-3)
    assert len(shapes) == 35  # half of 10 x 7
    found, _ = cv2.findChessboardCornersSB(raster(size, shapes, 4), (9, 6))
    assert found


def test_aprilgrid_has_kalibrs_geometry(tmp_path: Path):
    board = AprilGrid(kind="aprilgrid", columns=4, rows=3, tag=0.03, spacing=0.3)
    board_sheet(board, tmp_path / "board.svg")
    size, shapes = svg_blacks(tmp_path / "board.svg")
    low, high = bounds(shapes)
    np.testing.assert_allclose(high - low, [4 * 39.0 + 9.0, 3 * 39.0 + 9.0], atol=1e-3)
    small = [shape for shape in shapes if np.allclose(np.ptp(np.concatenate(shape), axis=0), 9.0, atol=1e-3)]
    assert len(small) == 5 * 4, "a small square at every corner of a tag, the outermost too"
    texture = raster(size, shapes)
    # the lower left tag is the family's first, upright as its makers draw it, its border two cells of ten wide
    left, top = low[0] + 9.0, high[1] - 39.0
    middles = 3.0 * np.arange(10) + 1.5
    x, y = (8 * (left + middles)).astype(int), (8 * (top + middles)).astype(int)
    cells = texture[np.ix_(y, x)] > 128
    assert not cells[:2].any()
    assert not cells[:, -2:].any()
    bits = cells[2:-2, 2:-2].ravel()
    assert int("".join("01"[int(bit)] for bit in bits), 2) == 0xD5D628584


def test_pdf_has_the_same_geometry(tmp_path: Path):
    page = board_sheet(CHARUCO, tmp_path / "board.pdf")
    box, text = pdf_strokes(tmp_path / "board.pdf")
    np.testing.assert_allclose(box[2:], page, atol=0.01)
    points = np.array([[float(v) for v in pair] for pair in re.findall(r"([-\d.]+) ([-\d.]+) [ml]\n", text)])
    mm = points * 25.4 / 72
    mm[:, 1] = page[1] - mm[:, 1]
    board_sheet(CHARUCO, tmp_path / "board.svg")
    drawn = np.concatenate([loop for shape in svg_blacks(tmp_path / "board.svg")[1] for loop in shape])
    assert len(drawn) > 500
    assert KDTree(mm).query(drawn)[0].max() < 1e-3


def test_ruler_measures_what_it_says(tmp_path: Path):
    board_sheet(CHARUCO, tmp_path / "board.svg")
    text = (tmp_path / "board.svg").read_text()
    ruler = re.search(r'<g id="ruler">\s*<path d="M ([\d.]+) ([\d.]+)\s*L ([\d.]+) ([\d.]+)', text)
    assert ruler
    x0, y0, x1, y1 = (float(v) for v in ruler.groups())
    assert y0 == y1
    assert (x1 - x0) * 25.4 / 72 == pytest.approx(200.0, abs=1e-3)


def test_markers_have_their_size_and_ids(tmp_path: Path):
    out = tmp_path / "markers.svg"
    assert marker_sheet([7, 3, 586, 12], 0.030, "apriltag_36h11", out, "markers") == (1, (210.0, 297.0))
    size, shapes = svg_blacks(out)
    assert len(shapes) == 4
    for shape in shapes:
        low, high = bounds([shape])
        np.testing.assert_allclose(high - low, 30.0, atol=1e-3)
    detector = cv2.aruco.ArucoDetector(opencv_dictionary("apriltag_36h11"))
    _, ids, _ = detector.detectMarkers(raster(size, shapes, 6))
    assert ids is not None
    assert sorted(np.ravel(ids)) == [3, 7, 12, 586]


def test_many_markers_go_on_several_pages(tmp_path: Path):
    sheets, _ = marker_sheet(list(range(60)), 0.030, "apriltag_36h11", tmp_path / "m.pdf")
    assert sheets == len(re.findall(rb"/Type /Page\b(?!s)", (tmp_path / "m.pdf").read_bytes())) == 3
    with pytest.raises(Refused, match=r"60 markers need 3 sheets and an SVG has one; write a \.pdf"):
        marker_sheet(list(range(60)), 0.030, "apriltag_36h11", tmp_path / "m.svg")


def test_a_large_board_gets_a_sheet_of_its_own(tmp_path: Path):
    page = board_sheet(Chessboard(kind="chessboard", columns=12, rows=9, square=0.1), tmp_path / "b.pdf")
    assert page[0] > 1300
    assert page[1] > 1000


def test_the_same_board_gives_the_same_file(tmp_path: Path):
    for suffix in ("svg", "pdf"):
        for name in ("a", "b"):
            board_sheet(CHESSBOARD, tmp_path / f"{name}.{suffix}")
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()


@pytest.mark.parametrize(
    ("ids", "size", "dictionary_name", "out", "says"),
    [
        ([], 0.03, "apriltag_36h11", "m.pdf", "no markers"),
        ([1, 1], 0.03, "apriltag_36h11", "m.pdf", "twice"),
        ([1], 30.0, "apriltag_36h11", "m.pdf", "a marker of 30 m"),
        ([1], 0.03, "apriltag", "m.pdf", "unknown dictionary"),
        ([600], 0.03, "apriltag_36h11", "m.pdf", "ids 0 to 586"),
        ([1], 0.03, "apriltag_36h11", "m.png", "unknown kind of sheet '.png'; valid: .pdf, .svg"),
        ([1], 0.03, "apriltag_36h11", "no/m.pdf", "does not exist"),
    ],
)
def test_refuses(tmp_path: Path, ids: list[int], size: float, dictionary_name: str, out: str, says: str):
    with pytest.raises(Refused, match=says):
        marker_sheet(ids, size, dictionary_name, tmp_path / out)
    assert list(tmp_path.iterdir()) == []


@given(arrays(bool, st.tuples(st.integers(1, 7), st.integers(1, 7))))
def test_outlines_enclose_exactly_the_black_cells(cells: np.ndarray):
    loops = [loop.astype(float) for loop in cell_outlines(cells)]
    filled = raster((cells.shape[1], cells.shape[0]), [loops], 1) == 0
    np.testing.assert_array_equal(filled, cells)


def test_an_outlined_marker_is_one_path_without_joints():
    cells = marker_cells("apriltag_36h11", 0)
    area = sum(
        0.5 * float(np.sum(loop[:, 0] * np.roll(loop[:, 1], -1) - loop[:, 1] * np.roll(loop[:, 0], -1)))
        for loop in cell_outlines(cells)
    )
    assert abs(area) == cells.sum()  # holes run the other way round
