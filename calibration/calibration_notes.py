"""What a person should know of a calibration, in sentences."""

from collections.abc import Sequence

import numpy as np

from calibration import board_shape, lens
from calibration.board_shape import BoardShape
from calibration.corner_detection import BoardView

_MAX_SIGMA_RATIO = 1.5
"""ratio of jackknife to least squares, either way, above which it is noted (docs/thresholds.md)"""


def coverage_notes(image_size: tuple[int, int], views: Sequence[BoardView]) -> list[str]:
    """The ninths of the picture without corners."""
    width, height = image_size
    points = np.concatenate([view.image_points for view in views])
    column = np.clip((3 * points[:, 0] / width).astype(int), 0, 2)
    row = np.clip((3 * points[:, 1] / height).astype(int), 0, 2)
    empty = [
        f"{('upper', 'middle', 'lower')[r]} {('left', 'middle', 'right')[c]}".replace("middle middle", "middle")
        for r in range(3)
        for c in range(3)
        if not np.any((column == c) & (row == r))
    ]
    if not empty:
        return []
    return [f"no corners in these ninths of the picture: {', '.join(empty)}; the lens is a guess there"]


def jackknife_notes(jackknife: np.ndarray, least_squares: np.ndarray) -> list[str]:
    """Where the standard deviations, both of shape (9,), of jackknife and least squares differ much."""
    notes = []
    free = least_squares > 0
    ratio = np.ones(9)
    ratio[free] = jackknife[free] / least_squares[free]
    for words, different in (("larger", ratio > _MAX_SIGMA_RATIO), ("smaller", ratio < 1 / _MAX_SIGMA_RATIO)):
        if different.any():
            names = ", ".join(f"{lens.PARAMETER_NAMES[i]} {ratio[i]:.1f}" for i in np.nonzero(different)[0])
            notes.append(f"sigma by leaving out views is {words} than that of least squares, times: {names}")
    return notes


def lens_range_notes(image_size: tuple[int, int], parameters: np.ndarray) -> list[str]:
    """Whether the lens model has no inverse in the picture's corners."""
    width, height = image_size
    border = np.array([[0, 0], [width - 1, 0], [0, height - 1], [width - 1, height - 1]], float)
    if not np.any(np.isnan(lens.pixels_to_rays(border, parameters))):
        return []
    return ["the lens model turns back before the picture's corners: do not use it there"]


def board_notes(shape: BoardShape, sigma: np.ndarray) -> list[str]:
    """The estimated shape of the board; sigma: of its shape parameters, shape (3,)."""
    free = shape.model.free
    words: list[str] = []
    if "bow_x" in free:
        bow, s = 1e3 * shape.values, 1e3 * sigma
        words.append(f"bowed by {bow[0]:.2f} +- {s[0]:.2f} mm along x and {bow[1]:.2f} +- {s[1]:.2f} mm along y")
    if "aspect" in free:
        i = board_shape.SHAPE_NAMES.index("aspect")
        words.append(f"with rows {100 * shape.values[i]:+.2f} +- {100 * sigma[i]:.2f} % apart")
    if shape.model.offsets:
        away = 1e3 * np.sqrt(np.mean(shape.offsets**2, axis=0))
        plane = float(np.hypot(away[0], away[1]))
        words.append(
            f"with corners off their places by {plane:.2f} mm in the plane and {away[2]:.2f} mm out of it (rms)"
        )
    return [f"the board is estimated {', '.join(words)}"] if words else []
