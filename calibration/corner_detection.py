"""Detection of a board's corners in one picture, to a few hundredths of a pixel."""

from collections import Counter
from dataclasses import dataclass, replace

import cv2
import numpy as np

from calibration.board import AprilGrid, Board, Charuco, Chessboard
from calibration.chessboard_order import in_one_order, row_direction
from calibration.dictionaries import is_upside_down, opencv_dictionary
from calibration.pictures import Picture
from calibration.saddle import fit_saddles

MIN_CORNERS = 6
"""corners of a view at least: four determine a pose, but then nothing shows whether it is right (docs/thresholds.md)"""
_MIN_TAGS = 4
"""tags of an AprilGrid that must be detected (docs/thresholds.md)"""
_MAX_SADDLE_RESIDUAL = 0.35
"""residual of a saddle over half the contrast, above which the detector's corner is kept instead (docs/thresholds.md)"""
_MAX_SADDLE_SIGMA_PX = 0.5
"""px: standard deviation of a saddle's point, above which the detector's corner is kept instead (docs/thresholds.md)"""


@dataclass(frozen=True)
class BoardVariant:
    """How a printed board differs from its file."""

    legacy: bool = False
    inverted: bool = False
    mirrored: bool = False

    def notes(self) -> tuple[str, ...]:
        """The differences, in sentences."""
        notes: list[str] = []
        if self.legacy:
            notes.append("the board has the legacy pattern of OpenCV before 4.6")
        if self.inverted:
            notes.append("the board is printed black for white")
        if self.mirrored:
            notes.append("the pictures (or the print) are mirrored: angles seen by this camera may have the wrong sign")
        return tuple(notes)


@dataclass(frozen=True)
class BoardView:
    """The corners of a board in one picture, with all that an estimator needs of the board."""

    name: str
    image_points: np.ndarray  # shape (k, 2), px, integer = pixel centre
    object_points: np.ndarray  # shape (k, 3), m, board frame
    corner_ids: np.ndarray  # shape (k,)
    sharpness: float = 1.0  # one over the blur's standard deviation across the more blurred edges, 1/px
    sigma: np.ndarray | None = None  # of one coordinate, shape (k,), px; infinite where the detector's corner was kept

    def of(self, index: np.ndarray) -> "BoardView":
        """The view with the corners of `index` only, an index array or mask."""
        return replace(
            self,
            image_points=self.image_points[index],
            object_points=self.object_points[index],
            corner_ids=self.corner_ids[index],
            sigma=None if self.sigma is None else self.sigma[index],
        )


class CornerDetector:
    """Detects one board in picture after picture; the first success decides how the board differs from its file."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self.variant: BoardVariant | None = None
        self.markers_without_board = 0  # pictures with markers of the dictionary but no board
        self.detected_sizes: Counter[tuple[int, int]] = (
            Counter()
        )  # sizes of chessboards in the pictures, larger count first
        self.rejected: list[Picture] = []  # a few pictures without the board, to describe what they show instead
        self._row_direction: np.ndarray | None = None  # of a chessboard in the last picture that showed it
        self._detectors: dict[bool, cv2.aruco.CharucoDetector] = {}

    def detect(self, picture: Picture) -> BoardView | None:
        """The board's corners in `picture`, or None where fewer than 6 of them, or only one line, are found."""
        if isinstance(self.board, Chessboard):
            view = self._chessboard_view(self.board, picture)
        else:
            rough = self._detect_rough(picture.grey)
            view = self._refined_view(picture, *rough) if rough else None
        if view is None and len(self.rejected) < 3:
            self.rejected.append(Picture(picture.name, picture.grey.copy()))
        return view

    def _detect_rough(self, grey: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Corners (k, 2), px, right to a few pixels, and their ids (k,); decides the variant."""
        if self.variant is not None:
            return self._marked(grey, self.variant)
        # an odd number of rows has one pattern only
        legacies = (False, True) if isinstance(self.board, Charuco) and self.board.rows % 2 == 0 else (False,)
        best: tuple[np.ndarray, np.ndarray] | None = None
        for variant in (
            BoardVariant(lg, inv, mir) for mir in (False, True) for inv in (False, True) for lg in legacies
        ):
            corners = self._marked(grey, variant)
            if corners and (best is None or len(corners[1]) > len(best[1])):
                best, self.variant = corners, variant
                if len(best[1]) > len(self.board.corners) // 2:
                    break
        return best

    def _marked(self, grey: np.ndarray, variant: BoardVariant) -> tuple[np.ndarray, np.ndarray] | None:
        """Corners of a board with markers, printed as `variant` says."""
        shown = 255 - grey if variant.inverted else grey
        shown = np.ascontiguousarray(shown[:, ::-1]) if variant.mirrored else shown
        if isinstance(self.board, AprilGrid):
            corners, markers = self._aprilgrid(self.board, shown)
        else:
            assert isinstance(self.board, Charuco)
            corners, markers = self._charuco(self.board, shown, variant.legacy)
        if corners is None:
            self.markers_without_board += markers > 1 and variant == BoardVariant()
            return None
        points, ids = corners
        if variant.mirrored:
            points[:, 0] = grey.shape[1] - 1 - points[:, 0]
        return points, ids

    def _charuco(
        self, board: Charuco, grey: np.ndarray, legacy: bool
    ) -> tuple[tuple[np.ndarray, np.ndarray] | None, int]:
        """Corners and ids, or None; and the number of markers detected."""
        if legacy not in self._detectors:
            self._detectors[legacy] = cv2.aruco.CharucoDetector(board.opencv(legacy))
        corners, ids, _, markers = self._detectors[legacy].detectBoard(grey)
        count = 0 if markers is None else len(markers)
        if ids is None or len(ids) < MIN_CORNERS:
            return None, count
        return (np.array(corners, np.float64).reshape(-1, 2), np.array(ids).ravel()), count

    def _aprilgrid(self, board: AprilGrid, grey: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray] | None, int]:
        """All corners of the board by a homography from the detected tags, with their ids; and the number of tags detected.

        A tag's outline merges with the small squares that touch it and bulges by some pixels at each of its corners, so that a
        single tag does not show where its corners are.
        """
        parameters = cv2.aruco.DetectorParameters()
        parameters.markerBorderBits = 2
        corners, ids, _ = cv2.aruco.ArucoDetector(opencv_dictionary(board.dictionary), parameters).detectMarkers(grey)
        tags = np.array([] if ids is None else ids, int).ravel() - board.first_id
        on_board = (tags >= 0) & (tags < board.columns * board.rows)
        if on_board.sum() < _MIN_TAGS:
            return None, len(tags)
        outlines = np.array(corners, np.float64).reshape(-1, 4, 2)[on_board]
        if is_upside_down(board.dictionary):
            outlines = np.roll(outlines, 2, axis=1)
        side = float(np.median(np.linalg.norm(outlines - np.roll(outlines, 1, axis=1), axis=2)))
        flat = board.corners.reshape(-1, 4, 3)[tags[on_board], :, :2].reshape(-1, 2)
        homography, agree = cv2.findHomography(flat, outlines.reshape(-1, 2), cv2.RANSAC, 0.2 * side)
        if homography is None or np.mean(agree) < 0.75:
            return None, len(tags)
        predicted = cv2.perspectiveTransform(board.corners[None, :, :2], homography)[0]
        inside = np.all((predicted > 2) & (predicted < np.array(grey.shape[::-1]) - 3), axis=1)
        return (predicted[inside], np.flatnonzero(inside)), len(tags)

    def _chessboard_view(self, board: Chessboard, picture: Picture) -> BoardView | None:
        """A chessboard's view, or None; counts the sizes of boards in the first pictures."""
        grey, size = picture.grey, (board.columns, board.rows)
        if sum(self.detected_sizes.values()) < 5:
            # a wrong size can succeed on a part of the board: count the sizes that some pictures show
            ok, _, meta = cv2.findChessboardCornersSBWithMeta(grey, (3, 3), cv2.CALIB_CB_LARGER)
            if ok and meta is not None:
                self.detected_sizes[max(meta.shape), min(meta.shape)] += 1
        # the sector-based search takes ten times as long; it finds more boards, but not all that the older one does
        best: BoardView | None = None
        for search in (_older_search, cv2.findChessboardCornersSB):
            ok, found = search(grey, size)
            if not ok:
                continue
            corners = np.array(found, np.float64).reshape(-1, 2)
            corners = in_one_order(grey, corners, *size, self._row_direction)
            view = self._refined_view(picture, corners, np.arange(len(corners)))
            if view is not None and (best is None or _clear_corners(view) > _clear_corners(best)):
                best = view
            if best is not None and _clear_corners(best) == len(corners):
                break
        if best is not None:
            self.variant = BoardVariant()
            self._row_direction = row_direction(best.image_points, *size)
        return best

    def _refined_view(self, picture: Picture, points: np.ndarray, ids: np.ndarray) -> BoardView | None:
        """The view with corners refined by saddles; None where they are too few or on one line."""
        # a mirrored picture needs no other object points: it shows the board as seen from behind through the paper
        objects = self.board.corners[ids]
        spread = np.linalg.svd(objects[:, :2] - objects[:, :2].mean(axis=0), compute_uv=False)
        homography, _ = cv2.findHomography(objects[:, :2], points) if spread[1] > 0.05 * spread[0] else (None, None)
        if homography is None:
            return None  # one line of corners has no pose
        squares = _squares_in_pixels(homography, objects, self.board.square)
        fitted = fit_saddles(picture.grey, points, squares, *self.board.window)
        narrow = np.linalg.svd(squares, compute_uv=False)[:, 1]
        shift = np.linalg.norm(fitted.points - points, axis=1)
        clear = (
            (fitted.residual < _MAX_SADDLE_RESIDUAL)
            & (shift < np.maximum(2.0, 0.3 * narrow))
            & (fitted.sigma < _MAX_SADDLE_SIGMA_PX)
        )
        refined = np.where(clear[:, None], fitted.points, points)
        blur = float(np.median(fitted.blur[clear].max(axis=1))) if clear.any() else np.inf
        sigma = np.where(clear, fitted.sigma, np.inf)
        view = BoardView(
            name=picture.name,
            image_points=refined,
            object_points=objects,
            corner_ids=ids,
            sharpness=1 / blur,
            sigma=sigma,
        )
        if isinstance(self.board, AprilGrid):
            view = view.of(clear)  # the others were predicted, not detected
        return view if len(view.corner_ids) >= MIN_CORNERS else None


def _older_search(grey: np.ndarray, size: tuple[int, int]) -> tuple[bool, np.ndarray]:
    """OpenCV's search for a chessboard by its squares' outlines: whether all corners were found, and where."""
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
    ok, corners = cv2.findChessboardCorners(grey, size, flags=flags)
    return bool(ok), np.asarray(corners)


def _clear_corners(view: BoardView) -> int:
    """How many corners of a view a saddle fits."""
    return 0 if view.sigma is None else int(np.isfinite(view.sigma).sum())


def prevailing_size(board: Chessboard, detected: Counter[tuple[int, int]]) -> tuple[int, int] | None:
    """The size of chessboard that most pictures show (larger count first) where it is not the board's, else None."""
    if not detected:
        return None
    size, votes = detected.most_common(1)[0]
    wrong = size != (max(board.columns, board.rows), min(board.columns, board.rows))
    return size if wrong and votes > sum(detected.values()) / 2 else None


def _squares_in_pixels(homography: np.ndarray, objects: np.ndarray, square: float) -> np.ndarray:
    """The two sides of a square in the picture at each corner, as columns: shape (k, 2, 2), px."""
    plane = np.column_stack([objects[:, :2], np.ones(len(objects))])
    u, v, w = homography @ plane.T
    # derivatives of u/w and v/w: the local linear map
    jacobian = np.stack(
        [
            (homography[0, :2] - np.outer(u / w, homography[2, :2])),
            (homography[1, :2] - np.outer(v / w, homography[2, :2])),
        ],
        axis=1,
    ) / w.reshape(-1, 1, 1)
    return square * jacobian
