"""Corners of a chessboard are numbered from the same end of the printed board in every picture, by whichever search finds them."""

import cv2
import numpy as np
import pytest

from calibration import corner_detection
from calibration.board import Chessboard
from calibration.corner_detection import CornerDetector
from calibration.pictures import Picture

SQUARE = 40


def drawn(columns: int, rows: int, turn_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """A picture of a board turned in its plane, and where the inner corners truly are, row by row, shape (rows columns, 2), px."""
    cells = np.indices((rows + 1, columns + 1)).sum(axis=0) % 2
    board = np.kron(np.where(cells == 0, 20, 230), np.ones((SQUARE, SQUARE))).astype(np.uint8)
    board = cv2.copyMakeBorder(board, SQUARE, SQUARE, SQUARE, SQUARE, cv2.BORDER_CONSTANT, value=(230,))
    middle = (np.array(board.shape[::-1]) - 1) / 2
    matrix = cv2.getRotationMatrix2D(tuple(middle), turn_deg, 0.75)
    matrix[:, 2] += np.array([320.0, 240.0]) - middle
    picture = cv2.warpAffine(board, matrix, (640, 480), flags=cv2.INTER_AREA, borderValue=(230,))
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
    # edges lie between pixels
    corners = (grid + 2.0) * SQUARE - 0.5
    return cv2.GaussianBlur(picture, (0, 0), 0.8), corners @ matrix[:, :2].T + matrix[:, 2]


@pytest.fixture(params=["both searches", "the older search alone", "the newer search alone"])
def searches(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    none = (False, None)
    if request.param == "the older search alone":
        monkeypatch.setattr(corner_detection.cv2, "findChessboardCornersSB", lambda *_: none)
    if request.param == "the newer search alone":
        monkeypatch.setattr(corner_detection, "_older_search", lambda *_: none)


@pytest.mark.usefixtures("searches")
def test_ends_of_other_colours_are_never_exchanged() -> None:
    board = Chessboard(kind="chessboard", columns=7, rows=4, square=0.03)
    for turn in (0.0, 100.0, 180.0, 250.0):
        # a detector of its own: nothing but the colours tells
        picture, corners = drawn(board.columns, board.rows, turn)
        view = CornerDetector(board).detect(Picture("board", picture))
        assert view is not None
        begins_at = [np.abs(view.image_points - order).max() < 0.2 for order in (corners, corners[::-1])]
        assert begins_at == [False, True], turn


@pytest.mark.usefixtures("searches")
def test_ends_of_one_colour_are_told_by_the_picture_before() -> None:
    board = Chessboard(kind="chessboard", columns=6, rows=4, square=0.03)
    detector, first = CornerDetector(board), []
    for turn in (0.0, 80.0, 160.0, 240.0, 320.0):
        picture, corners = drawn(board.columns, board.rows, turn)
        view = detector.detect(Picture("board", picture))
        assert view is not None
        first.append(int(np.argmin(np.linalg.norm(corners - view.image_points[0], axis=1))))
    assert len(set(first)) == 1
