"""board.yaml: what a calibration board looks like.

The board frame lies in the board's plane: x right, y down in the drawing, z into the board, origin at the outer corner
of the first square (ChArUco) or at the first inner corner (chessboard).
"""

from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

import cv2
import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from calibration.dictionaries import dictionary, dictionary_names, dictionary_size
from xneck.errors import Refused, one_of
from xneck.strict_yaml import Strict, load, validate

Count = Annotated[int, Field(ge=3, le=50)]
Square = Annotated[float, Field(ge=0.001, le=0.5)]  # m


class Charuco(Strict):
    """A chessboard with a marker in every white square; `columns` and `rows` count squares."""

    kind: Literal["charuco"]
    columns: Count
    rows: Count
    square: Square
    marker: Annotated[float, Field(gt=0.0)]
    dictionary: str

    @field_validator("marker")
    @classmethod
    def _fits(cls, marker: float, info: ValidationInfo) -> float:
        square = info.data.get("square")
        if square is not None and not 0.2 * square <= marker <= 0.95 * square:
            raise ValueError(f"expected 0.2 to 0.95 of the square ({0.2 * square:.4g} to {0.95 * square:.4g} m)")
        return marker

    @field_validator("dictionary")
    @classmethod
    def _known(cls, name: str, info: ValidationInfo) -> str:
        if name not in dictionary_names():
            raise ValueError(f"unknown dictionary, valid: {', '.join(dictionary_names())}")
        needed = info.data.get("columns", 0) * info.data.get("rows", 0) // 2
        if needed > dictionary_size(name):
            raise ValueError(f"has {dictionary_size(name)} markers, the board needs {needed}")
        return name

    @cached_property
    def corners(self) -> np.ndarray:
        """Inner corners in the board frame by id, shape (n, 3), m."""
        return _grid(self.columns - 1, self.rows - 1, self.square) + np.array([self.square, self.square, 0.0])

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the drawing, m."""
        return self.columns * self.square, self.rows * self.square

    @property
    def title(self) -> str:
        """The board in words, with its sizes."""
        return (
            f"ChArUco {self.columns} x {self.rows} squares of {1e3 * self.square:g} mm, "
            f"markers {1e3 * self.marker:g} mm, {self.dictionary}"
        )

    def opencv(self, legacy: bool = False) -> cv2.aruco.CharucoBoard:
        """OpenCV's description; `legacy` is the pattern of OpenCV before 4.6 (differs where rows are even)."""
        board = cv2.aruco.CharucoBoard((self.columns, self.rows), self.square, self.marker, dictionary(self.dictionary))
        board.setLegacyPattern(legacy)
        return board


class Chessboard(Strict):
    """A plain chessboard; `columns` and `rows` count inner corners."""

    kind: Literal["chessboard"]
    columns: Count
    rows: Count
    square: Square

    @cached_property
    def corners(self) -> np.ndarray:
        """Inner corners in the board frame, row by row, shape (n, 3), m."""
        return _grid(self.columns, self.rows, self.square)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the drawing, m."""
        return (self.columns + 1) * self.square, (self.rows + 1) * self.square

    @property
    def title(self) -> str:
        """The board in words, with its sizes."""
        return f"Chessboard {self.columns} x {self.rows} inner corners, squares of {1e3 * self.square:g} mm"


Board = Charuco | Chessboard


def read_board(path: str | Path) -> Board:
    """board.yaml as a board. Raises Refused with every fault of the file and its key's path."""
    document = load(path)
    kind = document.get("kind") if isinstance(document, dict) else None
    if kind == "aprilgrid":
        raise Refused(path, "boards of the kind aprilgrid are not yet read", "use charuco or chessboard")
    if kind is not None:
        one_of(path, str(kind), ["charuco", "chessboard"], "kind of board")
    return validate(document, Chessboard if kind == "chessboard" else Charuco, path)


def _grid(columns: int, rows: int, square: float) -> np.ndarray:
    """Corner positions row by row, shape (columns * rows, 3), in units of `square`'s."""
    grid = np.zeros((rows * columns, 3))
    grid[:, :2] = np.mgrid[0:columns, 0:rows].T.reshape(-1, 2) * square
    return grid
