"""Description of what pictures show that do not show the board of the file: another dictionary, other columns or rows."""

from collections.abc import Sequence

import cv2
import numpy as np

from calibration.board import AprilGrid, Board, Charuco, Chessboard
from calibration.dictionaries import dictionary_names, dictionary_size, opencv_dictionary
from calibration.pictures import Picture
from calibration.plain_chessboard import plain_chessboard

_MIN_MARKERS = 4
"""markers of a dictionary in one picture, from which on it is named (docs/thresholds.md)"""
_MAX_COLUMNS = 30


def describe_mismatch(board: Board, pictures: Sequence[Picture]) -> str | None:
    """What `pictures`, which do not show `board`, show instead, in words; None where that is not clear."""
    if isinstance(board, Chessboard):
        name, ids, _ = _most_markers(pictures, 1)
        return f"markers of {name}: is it a ChArUco board?" if len(set(ids)) >= 2 * _MIN_MARKERS else None
    border = 2 if isinstance(board, AprilGrid) else 1
    name, ids, centres = _most_markers(pictures, border, board.dictionary)
    if len(ids) < _MIN_MARKERS:
        name, ids, centres = _most_markers(pictures, border)
    if len(ids) < _MIN_MARKERS:
        sizes = [size for picture in pictures if (size := plain_chessboard(picture.grey))]
        return f"a chessboard of {sizes[0][0]} x {sizes[0][1]} inner corners, without markers" if sizes else None
    columns = _columns(board, ids, centres)
    if name != board.dictionary:
        return f"markers of {name}, not of {board.dictionary}"
    if columns is None:
        return None
    rows = max(int(_cell(board, columns, ids)[:, 1].max()) + 1, 0)
    return f"a board of {columns} columns and {rows} or more rows, not of {board.columns} x {board.rows}"


def _most_markers(
    pictures: Sequence[Picture], border: int, only: str | None = None
) -> tuple[str, np.ndarray, np.ndarray]:
    """The dictionary with most markers in one picture, their ids and their middles, shape (n, 2), px.

    Of dictionaries that contain one another the smallest is taken. Black for white is tried where nothing else is detected.
    """
    parameters = cv2.aruco.DetectorParameters()
    parameters.markerBorderBits = border
    parameters.errorCorrectionRate = 0.0  # a loose reading finds the markers of every dictionary
    best: tuple[str, np.ndarray, np.ndarray] = ("", np.empty(0, int), np.empty((0, 2)))
    names = sorted(dictionary_names() if only is None else [only], key=dictionary_size)

    def quads(picture: Picture) -> int:
        corners, _, rejected = cv2.aruco.ArucoDetector(opencv_dictionary(names[0]), parameters).detectMarkers(
            picture.grey
        )
        return len(corners) + len(rejected)

    # large dictionaries take their time: one picture will do
    grey = max(pictures, key=quads).grey if pictures else np.zeros((64, 64), np.uint8)
    for shown in (grey, 255 - grey):
        for name in names:
            if len(best[1]) >= _MIN_MARKERS and name.rsplit("_", 1)[0] != best[0].rsplit("_", 1)[0]:
                continue  # the others read what is no marker of theirs
            corners, ids, _ = cv2.aruco.ArucoDetector(opencv_dictionary(name), parameters).detectMarkers(shown)
            if ids is not None and len(ids) > len(best[1]):
                best = name, np.array(ids, int).ravel(), np.array(corners, float).reshape(-1, 4, 2).mean(axis=1)
        if len(best[1]) >= _MIN_MARKERS:
            break
    return best


def _columns(board: Charuco | AprilGrid, ids: np.ndarray, centres: np.ndarray) -> int | None:
    """The number of columns for which the markers' ids agree with their places in the picture."""
    for columns in range(2, _MAX_COLUMNS):
        cells = _cell(board, columns, ids).astype(float)
        if np.linalg.matrix_rank(cells - cells.mean(axis=0)) < 2:
            continue
        homography, _ = cv2.findHomography(cells, centres, 0)
        if homography is None:
            continue
        distance = np.linalg.norm(cv2.perspectiveTransform(cells[None], homography)[0] - centres, axis=1)
        between = np.linalg.norm(centres[:, None] - centres[None], axis=2)
        pitch = float(np.median(np.sort(between, axis=1)[:, 1]))
        if len(ids) > _MIN_MARKERS and distance.max() < 0.2 * pitch:
            return columns
    return None


def _cell(board: Charuco | AprilGrid, columns: int, ids: np.ndarray) -> np.ndarray:
    """Column and row of the cells of markers with these ids on a board of so many columns, shape (n, 2)."""
    if isinstance(board, AprilGrid):
        index = ids - board.first_id
        return np.column_stack([index % columns, index // columns])
    # white squares row by row, the first of the first row being the second
    count = int(ids.max()) + 1
    row, column = np.divmod(np.arange(2 * count + 2 * columns), columns)
    white = (row + column) % 2 == 1
    return np.column_stack([column[white], row[white]])[ids]
