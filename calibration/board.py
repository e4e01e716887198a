"""board.yaml: what a calibration board looks like.

The board frame lies in the board's plane: x right, y down in the drawing, z into the board, origin at the outer corner
of the first square (ChArUco), at the first inner corner (chessboard) or at the outer corner of the upper left tag (AprilGrid).
"""

from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

import cv2
import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from calibration.dictionaries import check_dictionary, opencv_dictionary
from xneck_foundation.errors import one_of
from xneck_foundation.strict_yaml import Strict, load_yaml, validate_document

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
    def _known_dictionary(cls, name: str, info: ValidationInfo) -> str:
        return check_dictionary(name, info.data.get("columns", 0) * info.data.get("rows", 0) // 2)

    @property
    def window(self) -> tuple[float, float]:
        """Radius around a corner, in squares, with nothing but its four squares: along the edges, and off the edges."""
        return 0.45, 0.45 * (1 - self.marker / self.square)

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
        board = cv2.aruco.CharucoBoard(
            (self.columns, self.rows), self.square, self.marker, opencv_dictionary(self.dictionary)
        )
        board.setLegacyPattern(legacy)
        return board


class Chessboard(Strict):
    """A plain chessboard; `columns` and `rows` count inner corners."""

    kind: Literal["chessboard"]
    columns: Count
    rows: Count
    square: Square

    @property
    def window(self) -> tuple[float, float]:
        """Radius around a corner, in squares, with nothing but its four squares: along the edges, and off the edges."""
        return 0.45, 0.45

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


class AprilGrid(Strict):
    """Tags in rows with a small black square at each of their corners, as Kalibr draws them.

    `columns` and `rows` count tags, `tag` is the side of a tag's black square, `spacing` the gap between two as a part of
    it. The tags' black border is two cells wide. The lower left tag has `first_id`; ids run to the right, then upwards.
    """

    kind: Literal["aprilgrid"]
    columns: Annotated[int, Field(ge=2, le=50)]
    rows: Annotated[int, Field(ge=2, le=50)]
    tag: Square
    spacing: Annotated[float, Field(ge=0.1, le=1.0)]
    first_id: Annotated[int, Field(ge=0)] = 0
    dictionary: Annotated[str, Field(validate_default=True)] = "apriltag_36h11"

    @field_validator("dictionary")
    @classmethod
    def _known_dictionary(cls, name: str, info: ValidationInfo) -> str:
        needed = info.data.get("columns", 0) * info.data.get("rows", 0) + info.data.get("first_id", 0)
        return check_dictionary(name, needed)

    @property
    def square(self) -> float:
        """Side of the small black squares, m."""
        return self.spacing * self.tag

    @property
    def window(self) -> tuple[float, float]:
        """Radius around a corner, in small squares, with nothing but them, the tag's border and white: along and off the edges."""
        border = 2 / (opencv_dictionary(self.dictionary).markerSize + 4) / self.spacing
        return min(0.6, 0.9 * border), min(0.6, 0.9 * border)

    @cached_property
    def corners(self) -> np.ndarray:
        """Corners of the tags in the board frame, shape (n, 3), m: four a tag, clockwise from its upper left one."""
        low = np.array([self.tag_place(index) for index in range(self.columns * self.rows)])
        around = self.tag * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        flat = (low[:, None] + around).reshape(-1, 2)
        return np.column_stack([flat, np.zeros(len(flat))])

    def tag_place(self, index: int) -> tuple[float, float]:
        """Upper left corner of the tag `first_id` + index in the board frame, m."""
        pitch = self.tag * (1 + self.spacing)
        return index % self.columns * pitch, (self.rows - 1 - index // self.columns) * pitch

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the drawing, m, its outermost small squares included."""
        pitch = self.tag * (1 + self.spacing)
        return self.columns * pitch + self.square, self.rows * pitch + self.square

    @property
    def title(self) -> str:
        """The board in words, with its sizes."""
        return (
            f"AprilGrid {self.columns} x {self.rows} tags of {1e3 * self.tag:g} mm, spacing {self.spacing:g}, "
            f"{self.dictionary} from id {self.first_id}"
        )


Board = Charuco | Chessboard | AprilGrid
_KINDS: dict[str, type[Board]] = {"charuco": Charuco, "chessboard": Chessboard, "aprilgrid": AprilGrid}


def read_board(path: str | Path) -> Board:
    """board.yaml as a board. Raises Refused with every fault of the file and its key's path."""
    document = load_yaml(path)
    kind = document.get("kind") if isinstance(document, dict) else None
    if kind is not None:
        one_of(path, str(kind), sorted(_KINDS), "kind of board")
    return validate_document(document, _KINDS.get(str(kind), Charuco), path)


def _grid(columns: int, rows: int, square: float) -> np.ndarray:
    """Corner positions row by row, shape (columns * rows, 3), in the unit of `square`."""
    grid = np.zeros((rows * columns, 3))
    grid[:, :2] = np.mgrid[0:columns, 0:rows].T.reshape(-1, 2) * square
    return grid
