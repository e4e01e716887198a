"""A chessboard without markers in a picture, of whatever size."""

import cv2
import numpy as np

MAX_SPREAD = 0.15
"""spread of the grey levels within a bright square over the contrast of the squares, above which markers are printed in them
(docs/thresholds.md)"""
_INSIDE = np.linspace(0.2, 0.8, 7)
"""places within a square, 0..1, along both sides"""


def plain_chessboard(grey: np.ndarray) -> tuple[int, int] | None:
    """Inner corners of a chessboard whose bright squares are empty, larger count first; None where there is none."""
    found, corners, meta = cv2.findChessboardCornersSBWithMeta(grey, (3, 3), cv2.CALIB_CB_LARGER)
    if not found or meta is None:
        return None
    rows, columns = meta.shape
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2).astype(np.float64)
    homography, _ = cv2.findHomography(grid, np.asarray(corners, np.float64).reshape(-1, 2))
    if homography is None:
        return None
    squares = np.stack(np.meshgrid(np.arange(columns - 1), np.arange(rows - 1)), axis=-1).reshape(-1, 1, 2)
    inside = squares + np.stack(np.meshgrid(_INSIDE, _INSIDE), axis=-1).reshape(1, -1, 2)
    places = cv2.perspectiveTransform(inside.reshape(1, -1, 2), homography)[0].astype(np.float32)
    levels = cv2.remap(grey, places[:, 0], places[:, 1], cv2.INTER_LINEAR).reshape(len(squares), -1).astype(float)
    median = np.median(levels, axis=1)
    is_bright = median > (median.min() + median.max()) / 2
    contrast = np.median(median[is_bright]) - np.median(median[~is_bright])
    if np.median(levels[is_bright].std(axis=1)) > MAX_SPREAD * contrast:
        return None
    return max(columns, rows), min(columns, rows)
