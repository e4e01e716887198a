"""What is said of a calibration has its numbers in millimetres and percent, and its places in the picture."""

from dataclasses import replace

import numpy as np

from calibration.board_shape import SHAPE_MODELS, flat_board
from calibration.calibration_notes import board_notes, coverage_notes
from calibration.corner_detection import BoardView


def test_the_shape_of_a_board_is_said_with_its_sigma() -> None:
    x, y = (side.ravel() for side in np.meshgrid(np.arange(5) * 0.03, np.arange(4) * 0.03))
    flat = flat_board(np.arange(20), np.stack([x, y, 0 * x], axis=1))
    bowed = replace(flat, model=SHAPE_MODELS["bowed, aspect"], values=np.array([0.4e-3, -0.25e-3, 0.002]))
    assert board_notes(bowed, np.array([0.05e-3, 0.03e-3, 0.0004])) == [
        "the board is estimated bowed by 0.40 +- 0.05 mm along x and -0.25 +- 0.03 mm along y, with rows +0.20 +- 0.04 % apart"
    ]
    assert board_notes(flat, np.zeros(3)) == []


def test_the_ninths_without_corners_are_named() -> None:
    """Of a picture twice as wide as high; corners in the middle of each ninth but two."""
    middles = np.array([(200.0 + 400 * c, 100.0 + 200 * r) for r in range(3) for c in range(3)])

    def said(points: np.ndarray) -> list[str]:
        view = BoardView("a.png", points, np.zeros((len(points), 3)), np.arange(len(points)))
        return coverage_notes((1200, 600), [view])

    assert said(middles) == []
    (note,) = said(np.delete(middles, [4, 8], axis=0))
    assert note.startswith("no corners in these ninths of the picture: middle, lower right;")
