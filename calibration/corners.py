"""The corners of a board in one picture, to a few hundredths of a pixel."""

from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np

from calibration.board import Board, Charuco, Chessboard
from calibration.pictures import Picture

_MIN_CORNERS = 6  # four would do for a pose, but then nothing tells whether it is right
_CRITERIA = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-4)


@dataclass(frozen=True)
class Variant:
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
    sharpness: float = 1.0  # steepest grey slope across the edges over their contrast, 1/px


class CornerFinder:
    """Finds one board in picture after picture; how the board departs from its file is settled by the first success."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self.variant: Variant | None = None
        self.markers_without_board = 0  # pictures with markers of the dictionary but no board
        self.seen_sizes: Counter[tuple[int, int]] = Counter()  # chessboards as pictures show them, larger count first
        self._detectors: dict[bool, cv2.aruco.CharucoDetector] = {}

    def find(self, picture: Picture) -> BoardView | None:
        """The board's corners in `picture`, or None where fewer than 6 of them, or only one line, are seen."""
        if isinstance(self.board, Chessboard):
            found = self._chessboard(self.board, picture.grey)
            self.variant = self.variant or (Variant() if found else None)
            return self._view(picture, *found) if found else None
        if self.variant is not None:
            found = self._charuco(self.board, picture.grey, self.variant)
            return self._view(picture, *found) if found else None
        # odd rows have one pattern only
        legacies = (False, True) if self.board.rows % 2 == 0 else (False,)
        best: tuple[np.ndarray, np.ndarray] | None = None
        for variant in (Variant(lg, inv, mir) for mir in (False, True) for inv in (False, True) for lg in legacies):
            found = self._charuco(self.board, picture.grey, variant)
            if found and (best is None or len(found[1]) > len(best[1])):
                best, self.variant = found, variant
                if len(best[1]) > len(self.board.corners) // 2:
                    break
        return self._view(picture, *best) if best else None

    def _charuco(self, board: Charuco, grey: np.ndarray, variant: Variant) -> tuple[np.ndarray, np.ndarray] | None:
        """Corners (k, 2) in px of `grey` and their ids (k,)."""
        if variant.legacy not in self._detectors:
            self._detectors[variant.legacy] = cv2.aruco.CharucoDetector(board.opencv(variant.legacy))
        shown = 255 - grey if variant.inverted else grey
        shown = np.ascontiguousarray(shown[:, ::-1]) if variant.mirrored else shown
        corners, ids, _, markers = self._detectors[variant.legacy].detectBoard(shown)
        if ids is None or len(ids) < _MIN_CORNERS:
            self.markers_without_board += markers is not None and len(markers) > 1 and variant == Variant()
            return None
        points = np.array(corners, np.float64).reshape(-1, 2)
        if variant.mirrored:
            points[:, 0] = grey.shape[1] - 1 - points[:, 0]
        return points, np.array(ids).ravel()

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
        spacing = _square_in_pixels(homography, objects, self.board.square)
        # half-windows in squares: on real sets 0.4 of a chessboard's square already takes in the next corner where the
        # board is steep, below 0.3 noise grows; between markers 0.8 of the white margin
        margin = 0.3 if isinstance(self.board, Chessboard) else 0.4 * (1 - self.board.marker / self.board.square)
        refined, half_windows = _refine(picture.grey, points, margin * spacing)
        sharpness = _sharpness(picture.grey, refined, half_windows)
        return BoardView(picture.name, refined, objects, ids, sharpness)


def expected_size(board: Chessboard, seen: Counter[tuple[int, int]]) -> tuple[int, int] | None:
    """The size of chessboard that most pictures show (larger count first) where it is not the board's, else None."""
    if not seen:
        return None
    size, votes = seen.most_common(1)[0]
    wrong = size != (max(board.columns, board.rows), min(board.columns, board.rows))
    return size if wrong and votes > sum(seen.values()) / 2 else None


def _square_in_pixels(homography: np.ndarray, objects: np.ndarray, square: float) -> np.ndarray:
    """A square's shortest extent in the picture at each corner, shape (k,), px: foreshortened edges crowd windows."""
    plane = np.column_stack([objects[:, :2], np.ones(len(objects))])
    u, v, w = homography @ plane.T
    # d(u/w)/dx and so on: the local linear map, whose smaller singular value is the foreshortened scale
    jacobian = np.stack(
        [
            (homography[0, :2] - np.outer(u / w, homography[2, :2])),
            (homography[1, :2] - np.outer(v / w, homography[2, :2])),
        ],
        axis=1,
    ) / w.reshape(-1, 1, 1)
    return square * np.linalg.svd(jacobian, compute_uv=False)[:, 1]


def _refine(grey: np.ndarray, points: np.ndarray, half_windows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Saddle points near `points`, shape (k, 2), px, each with a window that holds its own four edges and no others."""
    windows = np.clip(np.round(half_windows), 2, 9).astype(int)
    refined = points.copy()
    for window in np.unique(windows):
        at = windows == window
        start = points[at].astype(np.float32).reshape(-1, 1, 2).copy()
        side = (int(window), int(window))
        refined[at] = cv2.cornerSubPix(np.ascontiguousarray(grey), start, side, (-1, -1), _CRITERIA).reshape(-1, 2)
    return refined, windows


def _sharpness(grey: np.ndarray, points: np.ndarray, windows: np.ndarray) -> float:
    """Median over the corners of the steepest slope over the contrast, 1/px, in the worse of the two directions.

    The worse direction counts because motion blurs one direction only.
    """
    values: list[float] = []
    height, width = grey.shape
    for (x, y), window in zip(points, windows, strict=True):
        half = int(window) + 1
        left, top = max(int(x) - half, 0), max(int(y) - half, 0)
        patch = grey[top : min(int(y) + half + 1, height), left : min(int(x) + half + 1, width)].astype(np.float32)
        contrast = float(np.ptp(patch)) if patch.size else 0.0
        if contrast > 0 and min(patch.shape) >= 3:
            slopes = [float(np.max(np.abs(np.diff(patch, axis=axis)))) for axis in (0, 1)]
            values.append(min(slopes) / contrast)
    return float(np.median(values)) if values else 0.0
