"""The noise of corner detection, estimated without a camera model.

Within a view pixels are a smooth function of the place on the board, whatever the lens and however the board is bent: a
homography and a polynomial of low degree. The residuals are the noise of corner detection (and of the print, corner by corner).
"""

import cv2
import numpy as np

from calibration.stacked_views import StackedViews

_MIN_REDUNDANCY = 4
"""least surplus of coordinates over coefficients, for each degree of the polynomial, with which a view's noise is estimated
(docs/thresholds.md)"""


def corner_noise(views: StackedViews) -> float | None:
    """Standard deviation of one coordinate, px: the median over views; None where no view has enough corners."""
    noises = [
        noise
        for at, visible in zip(views.pixels, views.visible, strict=True)
        if (noise := _view_noise(views.nominal[visible][:, :2], at[visible])) is not None
    ]
    return float(np.median(noises)) if noises else None


def _view_noise(board: np.ndarray, pixels: np.ndarray) -> float | None:
    """Noise of the corners at `board` (k, 2), m, and `pixels` (k, 2) of one view, px; None where they are too few."""
    degree = max(
        (d for d in (2, 3, 4) if 2 * (len(board) - (d + 1) * (d + 2) // 2) >= _MIN_REDUNDANCY * d), default=None
    )
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
    residuals = pixels - mapped - terms @ fitted
    # the median distance, which a bad corner does not change
    spread = np.median(np.linalg.norm(residuals, axis=1)) / np.sqrt(2 * np.log(2))
    return float(spread * np.sqrt(len(board) / (len(board) - terms.shape[1])))
