"""A marker is printed: its white cells and its margin stand out from black alike."""

import numpy as np
import pytest

from calibration.dictionaries import marker_cells
from mechanism.printed_markers import BarMarker, Markers
from vision.markers.cell_reading import read_cells
from vision.markers.detection import MarkerDetector
from xneck_foundation.errors import Refused

SIDE, CELL = 160, 10
CELLS = marker_cells("aruco_4x4_50", 7)  # 6 x 6, border included
LOW = SIDE / 2 - 3 * CELL - 0.5
HIGH = LOW + 6 * CELL
CORNERS = np.array([[[LOW, LOW], [HIGH, LOW], [HIGH, HIGH], [LOW, HIGH]]])


def picture(paper: int, ink: int, cells: np.ndarray = CELLS) -> np.ndarray:
    """A marker on paper, grey levels."""
    out = np.full((SIDE, SIDE), paper, dtype=np.uint8)
    first = SIDE // 2 - 3 * CELL
    printed = np.where(cells, ink, paper)
    out[first : first + 6 * CELL, first : first + 6 * CELL] = np.kron(printed, np.ones((CELL, CELL))).astype(np.uint8)
    return out


@pytest.mark.parametrize(("paper", "ink"), [(230, 20), (60, 30), (255, 200)])
def test_a_marker_is_read_in_any_light(paper: int, ink: int) -> None:
    read = read_cells(picture(paper, ink), CORNERS, CELLS[None])
    assert read.right_share == pytest.approx([1.0])
    assert read.contrast == pytest.approx([paper - ink])
    assert read.margin_contrast == pytest.approx([paper - ink])
    assert read.is_printed.all()


def test_what_noise_makes_of_a_dark_square_is_none() -> None:
    """On dark ground, on white paper with a pattern of 12 grey levels in black, and with one of 3."""
    on_dark = picture(40, 20)
    pattern = picture(230, 20)
    inside = pattern[50:110, 50:110]
    faint, fainter = pattern.copy(), pattern.copy()
    faint[50:110, 50:110] = np.where(inside > 100, 32, 20)
    fainter[50:110, 50:110] = np.where(inside > 100, 23, 20)
    on_dark[50:110, 50:110] = np.where(inside > 100, 90, 40)
    for wrong in (faint, fainter, on_dark):
        assert not read_cells(wrong, CORNERS, CELLS[None]).is_printed.any()


def test_the_detector_leaves_it_out() -> None:
    markers = Markers(dictionary="aruco_4x4_50", size=0.02, on_bars=(BarMarker(id=7, bar=0),))
    faint = picture(230, 20)
    faint[50:110, 50:110] = np.where(faint[50:110, 50:110] > 100, 38, 20)
    for search in (MarkerDetector(markers).detect_all, MarkerDetector(markers).detect_small):
        assert [i for i, _ in search(picture(230, 20))] == [7]
        assert search(faint) == []


def test_markers_that_are_in_no_dictionary_are_refused_before_a_picture_is_looked_at() -> None:
    for dictionary, marker_id, says in (
        ("apriltag_36h11", 99999, "marker 99999: apriltag_36h11 has the ids 0 to 586"),
        ("apriltag_36H11", 0, "unknown dictionary 'apriltag_36H11'; did you mean apriltag_36h11"),
    ):
        with pytest.raises(Refused, match=says):
            MarkerDetector(Markers(dictionary=dictionary, size=0.02, on_bars=(BarMarker(id=marker_id, bar=0),)))
