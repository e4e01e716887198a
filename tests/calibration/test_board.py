from pathlib import Path

import numpy as np
import pytest

from calibration.board import AprilGrid, Charuco, Chessboard, read_board
from xneck_foundation.errors import Refused

GOOD = {"kind": "charuco", "columns": 9, "rows": 6, "square": 0.025, "marker": 0.0175, "dictionary": "aruco_5x5_100"}


def write(folder: Path, **changes: object) -> Path:
    keys = {**GOOD, **changes}
    path = folder / "board.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in keys.items() if value is not None))
    return path


def test_reads_charuco_with_opencvs_corners(tmp_path: Path):
    board = read_board(write(tmp_path))
    assert isinstance(board, Charuco)
    np.testing.assert_allclose(board.corners, board.opencv().getChessboardCorners(), atol=1e-8)
    assert board.size == pytest.approx((0.225, 0.15))


def test_reads_chessboard(tmp_path: Path):
    board = read_board(write(tmp_path, kind="chessboard", marker=None, dictionary=None))
    assert isinstance(board, Chessboard)
    assert board.corners.shape == (54, 3)
    np.testing.assert_allclose(board.corners[10], [0.025, 0.025, 0.0])


def test_reads_aprilgrid_as_kalibr_means_it(tmp_path: Path):
    path = tmp_path / "grid.yaml"
    path.write_text("{kind: aprilgrid, columns: 6, rows: 4, tag: 0.03, spacing: 0.3, first_id: 10}")
    board = read_board(path)
    assert isinstance(board, AprilGrid)
    assert board.dictionary == "apriltag_36h11"
    corners = board.corners.reshape(24, 4, 3)
    # the first tag is the lower left one, y down; the pitch is tag * (1 + spacing)
    np.testing.assert_allclose(corners[0][:, :2], [[0, 0.117], [0.03, 0.117], [0.03, 0.147], [0, 0.147]])
    np.testing.assert_allclose(corners[7][0], [0.039, 0.078, 0.0])
    path.write_text("{kind: aprilgrid, columns: 6, rows: 4, tag: 0.03, spacing: 0.3, first_id: 564}")
    with pytest.raises(Refused, match="has 587 markers, the board needs 588"):
        read_board(path)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"square": 25}, "square: .*less than or equal to 0.5.*found 25"),
        ({"square": 0.0005}, "square: .*greater than or equal to 0.001"),
        ({"columns": 2}, "columns: .*greater than or equal to 3.*found 2"),
        ({"rows": 51}, "rows: .*less than or equal to 50"),
        ({"columns": 9.5}, "columns: .*integer"),
        ({"marker": 0.025}, "marker: expected 0.2 to 0.95 of the square"),
        ({"marker": None}, "marker: missing"),
        ({"dictionary": "DICT_5X5_100"}, "dictionary: unknown dictionary, did you mean aruco_5x5_100?"),
        ({"columns": 20, "rows": 20}, "dictionary: has 100 markers, the board needs 200"),
        ({"kind": "circles"}, "unknown kind of board 'circles'; valid: aprilgrid, charuco, chessboard"),
        ({"kind": "aprilgrid"}, "tag: missing"),
        ({"kind": None}, "kind: missing"),
        ({"colour": "red"}, "colour: unknown key"),
        ({"kind": "chessboard"}, "marker: unknown key"),
    ],
)
def test_refuses(tmp_path: Path, changes: dict[str, object], says: str):
    with pytest.raises(Refused, match=says):
        read_board(write(tmp_path, **changes))


def test_all_faults_at_once(tmp_path: Path):
    with pytest.raises(Refused, match=r"columns: .*rows: .*square: "):
        read_board(write(tmp_path, columns=1, rows=1, square=7))
