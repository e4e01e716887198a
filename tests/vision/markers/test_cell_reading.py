"""A marker is printed: its white cells and its margin stand out from black alike."""

import cv2
import numpy as np
import pytest

from calibration.dictionaries import marker_cells
from mechanism.printed_markers import BarMarker, Markers
from vision.markers.cell_reading import pattern_correlation, read_cells
from vision.markers.detection import MIN_CORRELATION, MarkerDetector
from vision.markers.tracking import MIN_CELL_SHARE
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


@pytest.mark.parametrize("marker_id", [39, 55, 57])
def test_a_marker_of_another_dictionary_is_not_read_as_one_of_this(marker_id: int) -> None:
    """Markers of 8 x 8 cells that, read at the middles of 6 x 6, are two cells or fewer from one of apriltag_16h5's 30."""
    dictionary, cells = "apriltag_16h5", marker_cells("apriltag_36h11", marker_id)
    grey = np.full((SIDE, SIDE), 230, dtype=np.uint8)
    grey[40:120, 40:120] = np.kron(np.where(cells, 20, 230), np.ones((10, 10)))
    grey = np.asarray(cv2.GaussianBlur(grey, (0, 0), 1.0), dtype=np.uint8)
    detector = MarkerDetector(Markers(dictionary=dictionary, size=0.02, on_bars=(BarMarker(id=0, bar=0),)))
    assert detector.detect_small(grey) == []
    corners = np.array([[[39.5, 39.5], [119.5, 39.5], [119.5, 119.5], [39.5, 119.5]]])
    asked = np.stack([np.rot90(marker_cells(dictionary, i), turn) for i in range(30) for turn in range(4)])
    every = np.repeat(corners, len(asked), axis=0)
    alike = read_cells(grey, every, asked).right_share
    assert alike.max() > MIN_CELL_SHARE
    assert pattern_correlation(grey, every, asked).max() < MIN_CORRELATION
    assert pattern_correlation(grey, corners, cells[None]) > 0.9


def test_markers_that_are_in_no_dictionary_are_refused_before_a_picture_is_looked_at() -> None:
    for dictionary, marker_id, says in (
        ("apriltag_36h11", 99999, "marker 99999: apriltag_36h11 has the ids 0 to 586"),
        ("apriltag_36H11", 0, "unknown dictionary 'apriltag_36H11'; did you mean apriltag_36h11"),
    ):
        with pytest.raises(Refused, match=says):
            MarkerDetector(Markers(dictionary=dictionary, size=0.02, on_bars=(BarMarker(id=marker_id, bar=0),)))
