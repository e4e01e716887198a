"""The corners of a board in one picture, to a few hundredths of a pixel."""

from collections import Counter
from dataclasses import dataclass, replace

import cv2
import numpy as np

from calibration.board import AprilGrid, Board, Charuco, Chessboard
from calibration.dictionaries import is_upside_down, opencv_dictionary
from calibration.pictures import Picture
from calibration.saddle import fit_saddles

MIN_CORNERS = 6  # four would do for a pose, but then nothing tells whether it is right
_MIN_TAGS = 4
_MOST_REST = (
    0.35  # of half the contrast: a corner under a reflection or a finger leaves 0.4 and more, a good one 0.05 to 0.2
)


@dataclass(frozen=True)
class BoardVariant:
    """How a board departs from what its file says."""

    legacy: bool = False
    inverted: bool = False
    mirrored: bool = False

    def notes(self) -> tuple[str, ...]:
        """What a person should know of it, in sentences."""
        words: list[str] = []
        if self.legacy:
            words.append("the board has the legacy pattern of OpenCV before 4.6")
        if self.inverted:
            words.append("the board is printed black for white")
        if self.mirrored:
            words.append("the pictures (or the print) are mirrored: angles seen by this camera may have the wrong sign")
        return tuple(words)


@dataclass(frozen=True)
class BoardView:
    """A board as one picture shows it; self-contained, so that an estimator needs nothing of the board's kind."""

    name: str
    image_points: np.ndarray  # shape (k, 2), px, integer = pixel centre
    object_points: np.ndarray  # shape (k, 3), m, board frame
    corner_ids: np.ndarray  # shape (k,)
    sharpness: float = 1.0  # one over the blur's standard deviation across the more blurred edges, 1/px
    sigma: np.ndarray | None = None  # of one coordinate, shape (k,), px; infinite: no saddle there, the detector's word

    def of(self, index: np.ndarray) -> "BoardView":
        """The view with some of its corners, `index` as numpy takes it."""
        return replace(
            self,
            image_points=self.image_points[index],
            object_points=self.object_points[index],
            corner_ids=self.corner_ids[index],
            sigma=None if self.sigma is None else self.sigma[index],
        )


class CornerDetector:
    """Finds one board in picture after picture; how the board departs from its file is settled by the first success."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self.variant: BoardVariant | None = None
        self.markers_without_board = 0  # pictures with markers of the dictionary but no board
        self.seen_sizes: Counter[tuple[int, int]] = Counter()  # chessboards as pictures show them, larger count first
        self.kept: list[Picture] = []  # a few of the pictures without the board, to say what they show instead
        self._detectors: dict[bool, cv2.aruco.CharucoDetector] = {}

    def find(self, picture: Picture) -> BoardView | None:
        """The board's corners in `picture`, or None where fewer than 6 of them, or only one line, are seen."""
        found = self._start(picture.grey)
        view = self._view(picture, *found) if found else None
        if view is None and len(self.kept) < 3:
            self.kept.append(Picture(picture.name, picture.grey.copy()))
        return view

    def _start(self, grey: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Corners (k, 2) in px to a few pixels and their ids (k,); settles the variant."""
        if isinstance(self.board, Chessboard):
            found = self._chessboard(self.board, grey)
            self.variant = self.variant or (BoardVariant() if found else None)
            return found
        if self.variant is not None:
            return self._marked(grey, self.variant)
        # an odd number of rows has one pattern only
        legacies = (False, True) if isinstance(self.board, Charuco) and self.board.rows % 2 == 0 else (False,)
        best: tuple[np.ndarray, np.ndarray] | None = None
        for variant in (BoardVariant(lg, inv, mir) for mir in (False, True) for inv in (False, True) for lg in legacies):
            found = self._marked(grey, variant)
            if found and (best is None or len(found[1]) > len(best[1])):
                best, self.variant = found, variant
                if len(best[1]) > len(self.board.corners) // 2:
                    break
        return best

    def _marked(self, grey: np.ndarray, variant: BoardVariant) -> tuple[np.ndarray, np.ndarray] | None:
        """Corners of a board with markers, printed as `variant` says."""
        shown = 255 - grey if variant.inverted else grey
        shown = np.ascontiguousarray(shown[:, ::-1]) if variant.mirrored else shown
        if isinstance(self.board, AprilGrid):
            found, markers = self._aprilgrid(self.board, shown)
        else:
            assert isinstance(self.board, Charuco)
            found, markers = self._charuco(self.board, shown, variant.legacy)
        if found is None:
            self.markers_without_board += markers > 1 and variant == BoardVariant()
            return None
        points, ids = found
        if variant.mirrored:
            points[:, 0] = grey.shape[1] - 1 - points[:, 0]
        return points, ids

    def _charuco(
        self, board: Charuco, grey: np.ndarray, legacy: bool
    ) -> tuple[tuple[np.ndarray, np.ndarray] | None, int]:
        """Corners and ids, or None; and the number of markers seen."""
        if legacy not in self._detectors:
            self._detectors[legacy] = cv2.aruco.CharucoDetector(board.opencv(legacy))
        corners, ids, _, markers = self._detectors[legacy].detectBoard(grey)
        count = 0 if markers is None else len(markers)
        if ids is None or len(ids) < MIN_CORNERS:
            return None, count
        return (np.array(corners, np.float64).reshape(-1, 2), np.array(ids).ravel()), count

    def _aprilgrid(self, board: AprilGrid, grey: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray] | None, int]:
        """Where the tags that are seen put all corners of the board, and their number.

        A tag's outline runs over into the small squares that touch it and bulges by some pixels at each of its corners,
        so that no single tag tells where its corners are.
        """
        parameters = cv2.aruco.DetectorParameters()
        parameters.markerBorderBits = 2
        corners, ids, _ = cv2.aruco.ArucoDetector(opencv_dictionary(board.dictionary), parameters).detectMarkers(grey)
        tags = np.array([] if ids is None else ids, int).ravel() - board.first_id
        own = (tags >= 0) & (tags < board.columns * board.rows)
        if own.sum() < _MIN_TAGS:
            return None, len(tags)
        seen = np.array(corners, np.float64).reshape(-1, 4, 2)[own]
        if is_upside_down(board.dictionary):
            seen = np.roll(seen, 2, axis=1)
        side = float(np.median(np.linalg.norm(seen - np.roll(seen, 1, axis=1), axis=2)))
        flat = board.corners.reshape(-1, 4, 3)[tags[own], :, :2].reshape(-1, 2)
        homography, agree = cv2.findHomography(flat, seen.reshape(-1, 2), cv2.RANSAC, 0.2 * side)
        if homography is None or np.mean(agree) < 0.75:
            return None, len(tags)
        every = cv2.perspectiveTransform(board.corners[None, :, :2], homography)[0]
        inside = np.all((every > 2) & (every < np.array(grey.shape[::-1]) - 3), axis=1)
        return (every[inside], np.flatnonzero(inside)), len(tags)

    def _chessboard(self, board: Chessboard, grey: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        size = (board.columns, board.rows)
        if sum(self.seen_sizes.values()) < 5:
            # a wrong size can succeed on a part of the board: let some pictures say what they show
            ok, _, meta = cv2.findChessboardCornersSBWithMeta(grey, (3, 3), cv2.CALIB_CB_LARGER)
            if ok and meta is not None:
                self.seen_sizes[max(meta.shape), min(meta.shape)] += 1
        # the sector-based detector finds more boards, the older one some that it does not
        ok, corners = cv2.findChessboardCornersSB(grey, size)
        if not ok:
            flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
            ok, corners = cv2.findChessboardCorners(grey, size, flags=flags)
        if not ok:
            return None
        return np.array(corners, np.float64).reshape(-1, 2), np.arange(board.columns * board.rows)

    def _view(self, picture: Picture, points: np.ndarray, ids: np.ndarray) -> BoardView | None:
        # a mirrored picture needs no other object points: it shows the board as seen from behind through the paper
        objects = self.board.corners[ids]
        spread = np.linalg.svd(objects[:, :2] - objects[:, :2].mean(axis=0), compute_uv=False)
        homography, _ = cv2.findHomography(objects[:, :2], points) if spread[1] > 0.05 * spread[0] else (None, None)
        if homography is None:
            return None  # one line of corners has no pose
        squares = _squares_in_pixels(homography, objects, self.board.square)
        fitted = fit_saddles(picture.grey, points, squares, *self.board.window)
        narrow = np.linalg.svd(squares, compute_uv=False)[:, 1]
        moved = np.linalg.norm(fitted.points - points, axis=1)
        settled = (fitted.rest < _MOST_REST) & (moved < np.maximum(2.0, 0.3 * narrow)) & (fitted.sigma < 0.5)
        refined = np.where(settled[:, None], fitted.points, points)
        blur = float(np.median(fitted.blur[settled].max(axis=1))) if settled.any() else np.inf
        sigma = np.where(settled, fitted.sigma, np.inf)
        view = BoardView(picture.name, refined, objects, ids, 1 / blur, sigma)
        if isinstance(self.board, AprilGrid):
            view = view.of(settled)  # the others were predicted, not seen
        return view if len(view.corner_ids) >= MIN_CORNERS else None


def prevailing_size(board: Chessboard, seen: Counter[tuple[int, int]]) -> tuple[int, int] | None:
    """The size of chessboard that most pictures show (larger count first) where it is not the board's, else None."""
    if not seen:
        return None
    size, votes = seen.most_common(1)[0]
    wrong = size != (max(board.columns, board.rows), min(board.columns, board.rows))
    return size if wrong and votes > sum(seen.values()) / 2 else None


def _squares_in_pixels(homography: np.ndarray, objects: np.ndarray, square: float) -> np.ndarray:
    """The sides of a square in the picture at each corner, as columns: shape (k, 2, 2), px."""
    plane = np.column_stack([objects[:, :2], np.ones(len(objects))])
    u, v, w = homography @ plane.T
    # d(u/w)/dx and so on: the local linear map
    jacobian = np.stack(
        [
            (homography[0, :2] - np.outer(u / w, homography[2, :2])),
            (homography[1, :2] - np.outer(v / w, homography[2, :2])),
        ],
        axis=1,
    ) / w.reshape(-1, 1, 1)
    return square * jacobian
