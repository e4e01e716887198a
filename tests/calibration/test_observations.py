"""Boards in rendered pictures: found to a few hundredths of a pixel, in every variant, and refused by name."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from calibration.board import AprilGrid, Board, Charuco, Chessboard
from calibration.estimation import calibrate
from calibration.observations import distinct_views, observe_board, without_hidden_corners
from calibration.pictures import Picture
from calibration.plain_chessboard import plain_chessboard
from calibration.sheets import board_sheet
from tests.calibration.truth import CAMERA, SIZE, picture, poses, project, raster, svg_blacks
from xneck_foundation.errors import Refused

CHARUCO = Charuco(kind="charuco", columns=9, rows=6, square=0.025, marker=0.0175, dictionary="aruco_5x5_100")
CHESSBOARD = Chessboard(kind="chessboard", columns=8, rows=5, square=0.025)
GRID = AprilGrid(kind="aprilgrid", columns=6, rows=4, tag=0.03, spacing=0.3)
PER_MM = 8


def rendered(board: Board, folder: Path, count: int, seed: int, **how: bool):
    """Pictures of the board as `board_sheet` draws it, and the true corner positions in each."""
    board_sheet(board, folder / "board.svg")
    size, shapes = svg_blacks(folder / "board.svg")
    texture = raster(size, shapes, PER_MM)
    points = np.concatenate([loop for shape in shapes for loop in shape])
    origin = points.min(axis=0)
    if not isinstance(board, Charuco):
        origin = origin + 1e3 * board.square  # its frame starts at the first inner corner, or tag
    if how.get("legacy"):
        plain = board.opencv(legacy=True).generateImage((225 * PER_MM, 150 * PER_MM))  # type: ignore[union-attr]
        texture = np.pad(plain, 20 * PER_MM, constant_values=255)
        origin = np.array([20.0, 20.0])
    if how.get("inverted"):
        texture = 255 - texture
    rng = np.random.default_rng(seed)
    pictures, truth = [], []
    for index, (R, t) in enumerate(poses(rng, count, board.size)):
        shot = picture(texture, PER_MM, (float(origin[0]), float(origin[1])), R, t, rng, f"{index:02d}.png")
        pixels = project(board.corners, R, t)
        if how.get("mirrored"):
            shot = Picture(shot.name, np.ascontiguousarray(shot.grey[:, ::-1]))
            pixels[:, 0] = SIZE[0] - 1 - pixels[:, 0]
        pictures.append(shot)
        truth.append(pixels)
    return pictures, truth


@pytest.fixture(scope="module")
def charuco(tmp_path_factory: pytest.TempPathFactory):
    return rendered(CHARUCO, tmp_path_factory.mktemp("charuco"), 10, 1)


def corner_errors(observations, truth) -> np.ndarray:
    return np.concatenate(
        [
            np.linalg.norm(view.image_points - truth[int(view.name[:2])][view.corner_ids], axis=1)
            for view in observations.views
        ]
    )


def test_printed_rendered_found_calibrated(charuco):
    pictures, truth = charuco
    observations = observe_board(iter(pictures), CHARUCO)
    assert len(observations.views) == 10
    assert observations.notes == ()
    errors = corner_errors(observations, truth)
    assert len(errors) > 380
    assert np.sqrt(np.mean(errors**2)) < 0.03
    assert errors.max() < 0.1
    sigma = np.concatenate([np.ravel(view.sigma) for view in observations.views])  # type: ignore[arg-type]
    assert 0.5 < np.sqrt(np.mean(errors**2 / (2 * sigma**2))) < 2.0, "claimed and true error"
    result = calibrate(observations)
    assert result.camera.covariance is not None
    z = (result.camera.parameters - CAMERA)[:8] / np.sqrt(np.diag(result.camera.covariance))[:8]
    assert np.abs(z).max() < 4.0
    assert abs(result.camera.parameters[0] - CAMERA[0]) < 1.5
    # what matters: where a ray goes
    grid = np.stack(np.meshgrid(np.linspace(20, 620, 9), np.linspace(20, 460, 7)), axis=-1).reshape(-1, 2)
    rays = result.camera.rays(grid)
    true_pixels = project(np.column_stack([rays, np.ones(len(rays))]), np.eye(3), np.zeros(3))
    direction = np.linalg.norm(true_pixels - grid - np.median(true_pixels - grid, axis=0), axis=1)
    assert np.median(direction) < 0.25


def test_chessboard(tmp_path: Path):
    pictures, truth = rendered(CHESSBOARD, tmp_path, 6, 2)
    observations = observe_board(pictures, CHESSBOARD)
    assert len(observations.views) == 6
    for view in observations.views:
        # 9 x 6 squares look the same turned by 180 degrees
        either = [truth[int(view.name[:2])][ids] for ids in (view.corner_ids, view.corner_ids[::-1])]
        assert min(np.abs(view.image_points - pixels).max() for pixels in either) < 0.1


@pytest.mark.parametrize("how", ["", "inverted", "mirrored"])
def test_aprilgrid(tmp_path: Path, how: str):
    pictures, truth = rendered(GRID, tmp_path, 2, 0, **({how: True} if how else {}))
    observations = observe_board(pictures, GRID)
    assert len(observations.views) == 2
    assert len(observations.notes) == bool(how)
    errors = corner_errors(observations, truth)
    assert len(errors) > 0.75 * 2 * 96  # small tags at the far end are left out where their saddles are unclear
    assert errors.max() < 0.1


def test_a_hidden_corner_has_no_say(charuco):
    pictures, truth = charuco
    grey = pictures[0].grey.copy()
    x, y = np.round(truth[0][20]).astype(int)
    grey[y - 3 : y + 3, x - 60 : x + 60] = 235  # a lamp's reflection along a row of corners
    observations = observe_board([Picture("00.png", grey)], CHARUCO)
    whole = observe_board(pictures[:1], CHARUCO)
    assert np.all(np.isfinite(whole.views[0].sigma))  # type: ignore[arg-type]
    clear = without_hidden_corners(observations)
    assert "hidden" in clear.notes[-1]
    assert corner_errors(clear, truth).max() < 0.1 < 0.5 < corner_errors(observations, truth).max()
    assert len(corner_errors(clear, truth)) > 35


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"columns": 7}, "show a board of 9 columns and 6 or more rows, not of 7 x 6"),
        ({"columns": 6, "rows": 9}, "show a board of 9 columns and 6 or more rows, not of 6 x 9"),
        ({"dictionary": "aruco_6x6_50"}, "show markers of aruco_5x5_50, not of aruco_6x6_50"),
    ],
)
def test_says_what_it_saw_instead(charuco, changes: dict[str, object], says: str):
    with pytest.raises(Refused, match=says):
        observe_board(charuco[0][:2], CHARUCO.model_copy(update=changes))


@pytest.mark.parametrize("board", [CHARUCO, GRID], ids=["charuco", "aprilgrid"])
def test_a_chessboard_in_the_place_of_a_board_with_markers_is_named(tmp_path: Path, board: Charuco | AprilGrid):
    pictures, _ = rendered(CHESSBOARD, tmp_path, 3, 4)
    with pytest.raises(
        Refused, match="the pictures show a chessboard of 8 x 5 inner corners, without markers; describe"
    ):
        observe_board(pictures, board)


def test_a_board_with_markers_is_no_chessboard(charuco):
    """Though OpenCV finds one in some of the pictures."""
    greys = [picture.grey for picture in charuco[0][:4]]
    assert any(cv2.findChessboardCornersSBWithMeta(grey, (3, 3), cv2.CALIB_CB_LARGER)[0] for grey in greys)
    assert [plain_chessboard(grey) for grey in greys] == [None] * 4


@pytest.mark.parametrize(
    ("how", "says"),
    [("legacy", "legacy pattern"), ("inverted", "black for white"), ("mirrored", "mirrored")],
)
def test_variants_are_resolved_and_reported(tmp_path: Path, how: str, says: str):
    pictures, truth = rendered(CHARUCO, tmp_path, 7 if how == "mirrored" else 2, 3, **{how: True})
    observations = observe_board(pictures, CHARUCO)
    assert len(observations.views) == len(pictures)
    assert len(observations.notes) == 1
    assert says in observations.notes[0]
    assert np.median(corner_errors(observations, truth)) < 0.03
    if how == "mirrored":
        # the camera is that of the pictures as they are: the optical axis mirrored, the focal length the same
        result = calibrate(observations)
        assert result.camera.K[0, 2] == pytest.approx(SIZE[0] - 1 - CAMERA[2], abs=3)
        assert result.camera.K[0, 0] == pytest.approx(CAMERA[0], abs=4)


def test_same_content_counts_once(charuco):
    pictures, _ = charuco
    again = Picture("copy.png", pictures[0].grey.copy())
    observations = observe_board([*pictures[:2], again], CHARUCO)
    assert [(entry.name, entry.why) for entry in observations.left_out] == [("copy.png", "the same picture as 00.png")]
    assert len(observations.views) == 2


def test_pictures_without_the_board_are_named(charuco):
    pictures, _ = charuco
    empty = Picture("empty.png", np.full((SIZE[1], SIZE[0]), 90, np.uint8))
    observations = observe_board([empty, *pictures[:2]], CHARUCO)
    assert [(entry.name, entry.why) for entry in observations.left_out] == [("empty.png", "the board was not found")]


def test_refuses_mixed_sizes(charuco):
    pictures, _ = charuco
    turned = Picture("turned.png", np.ascontiguousarray(pictures[1].grey.T))
    with pytest.raises(Refused, match=r"turned.png: is 480 x 640 px, 00.png is 640 x 480 px"):
        observe_board([pictures[0], turned], CHARUCO)


def test_refuses_when_no_picture_shows_the_board():
    with pytest.raises(Refused, match="none given"):
        observe_board([], CHARUCO)
    with pytest.raises(Refused, match="not found in any of 1 pictures; expected: ChArUco 9 x 6 squares of 25 mm"):
        observe_board([Picture("empty", np.zeros((480, 640), np.uint8))], CHARUCO)


def test_refuses_another_size_of_chessboard(tmp_path: Path):
    pictures, _ = rendered(CHESSBOARD, tmp_path, 3, 4)
    for columns, rows in ((7, 5), (9, 6), (5, 4)):
        wrong = CHESSBOARD.model_copy(update={"columns": columns, "rows": rows})
        with pytest.raises(Refused, match=rf"show a chessboard of 8 x 5 inner corners, not {columns} x {rows}"):
            observe_board(pictures, wrong)
    assert len(observe_board(pictures, CHESSBOARD.model_copy(update={"columns": 5, "rows": 8})).views) == 3


def test_distinct_views_are_sharp_and_differ(charuco):
    pictures, _ = charuco
    stream = []
    stream += [Picture(f"blurred {i}", cv2.blur(shot.grey, (5, 1))) for i, shot in enumerate(pictures[6:9])]
    for index, sharp in enumerate(pictures[:6]):
        for k in range(5):  # the board rests for five frames, moving blurs two of them
            grey = cv2.blur(sharp.grey, (5, 1)) if k in (0, 4) else np.roll(sharp.grey, k, axis=1)
            stream.append(Picture(f"{index}{k}", grey))
    chosen = distinct_views(observe_board(iter(stream), CHARUCO))
    assert sorted({view.name[0] for view in chosen.views}) == list("012345"), "not where all is blurred"
    assert not [view.name for view in chosen.views if view.name[1] in "04"]
    assert len(chosen.views) <= 8
    assert "distinct views kept" in chosen.notes[-1]
    assert len(distinct_views(observe_board(iter(stream), CHARUCO), limit=3).views) == 3
