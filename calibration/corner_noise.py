"""How well the corners of these pictures were found, without asking any camera.

Within a view pixels are a smooth function of the place on the board, whatever the lens and however the board is bent:
a homography and a polynomial of low degree. What that leaves is the noise of corner finding (and of print, corner by
corner).
"""

import cv2
import numpy as np

from calibration.stacked_views import StackedViews

_LEAST = 4
"""coordinates left over for each degree of the polynomial that make a view's noise worth anything"""


def corner_noise(sightings: StackedViews) -> float | None:
    """Standard deviation of one coordinate, px: the median over views; None where no view has corners enough."""
    found = [
        noise
        for at, seen in zip(sightings.pixels, sightings.seen, strict=True)
        if (noise := _of_view(sightings.nominal[seen][:, :2], at[seen])) is not None
    ]
    return float(np.median(found)) if found else None


def _of_view(board: np.ndarray, pixels: np.ndarray) -> float | None:
    degree = max((d for d in (2, 3, 4) if 2 * (len(board) - (d + 1) * (d + 2) // 2) >= _LEAST * d), default=None)
    if degree is None:
        return None
    homography, _ = cv2.findHomography(board, pixels)
    if homography is None:
        return None
    mapped = cv2.perspectiveTransform(board.reshape(-1, 1, 2), homography).reshape(-1, 2)
    unit = (board - board.mean(axis=0)) / np.maximum(np.ptp(board, axis=0), 1e-12)
    terms = np.stack(
        [unit[:, 0] ** i * unit[:, 1] ** j for i in range(degree + 1) for j in range(degree + 1 - i)], axis=1
    )
    fitted, *_ = np.linalg.lstsq(terms, pixels - mapped, rcond=None)
    left = pixels - mapped - terms @ fitted
    # the median distance: one bad corner is no noise
    spread = np.median(np.linalg.norm(left, axis=1)) / np.sqrt(2 * np.log(2))
    return float(spread * np.sqrt(len(board) / (len(board) - terms.shape[1])))
