"""One numbering of a chessboard's corners in all pictures: detectors begin at either end of the board, as the picture suggests.

What pictures say together of the board's shape would be lost where its ends are exchanged between them. Where the board's two ends
differ in colour (columns and rows of inner corners are odd in sum), the colour tells them apart. Where they do not, the board is
taken to be turned by less than a quarter between pictures that follow each other.
"""

import cv2
import numpy as np


def begins_dark(grey: np.ndarray, corners: np.ndarray, columns: int, rows: int) -> bool:
    """Whether the square between the first four corners is the dark one of its neighbours; corners (rows columns, 2), px."""
    grid = corners.reshape(rows, columns, 2)
    middles = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]).astype(np.float32) / 4
    values = cv2.remap(grey, middles[..., 0], middles[..., 1], cv2.INTER_LINEAR).astype(float)
    row, column = np.indices(values.shape)
    return float(np.sum(np.where((row + column) % 2, -1.0, 1.0) * (values - values.mean()))) < 0


def row_direction(corners: np.ndarray, columns: int, rows: int) -> np.ndarray:
    """Mean vector from a corner to the next in its row, shape (2,), px."""
    return np.diff(corners.reshape(rows, columns, 2), axis=1).mean(axis=(0, 1))


def in_one_order(
    grey: np.ndarray, corners: np.ndarray, columns: int, rows: int, previous: np.ndarray | None
) -> np.ndarray:
    """The corners (rows columns, 2), px, from the end of the board at which they begin in all pictures.

    previous: `row_direction` in the picture before, None in the first.
    """
    if (columns + rows) % 2:
        turned = begins_dark(grey, corners, columns, rows)
    else:
        turned = previous is not None and float(row_direction(corners, columns, rows) @ previous) < 0
    return corners[::-1].copy() if turned else corners
