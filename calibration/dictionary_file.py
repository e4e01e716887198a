"""A marker dictionary of one's own as a YAML file: every marker drawn as rows of cells."""

from functools import cache
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import Strict, read_yaml

FOLDER = Path(__file__).parent / "marker_dictionaries"
"""where the files are; <name>.yaml holds the dictionary <name>"""
_WHITE, _BLACK = ".", "#"


class _File(Strict):
    xneck: Literal[1]
    cells: Annotated[int, Field(ge=3, le=20)]
    corrected_cells: Annotated[int, Field(ge=0, le=50)] = 0
    markers: Annotated[tuple[tuple[str, ...], ...], Field(min_length=1, max_length=10_000)]


@cache
def dictionary_files() -> dict[str, Path]:
    """The files of FOLDER by the name of their dictionary."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.yaml"))}


def read_dictionary(path: Path) -> tuple[NDArray[np.bool_], int]:
    """The markers' cells without their black border, (markers, n, n), True = white, and how many cells may be misread.

    Raises Refused for a file that is not as docs/new-dictionary.md says, and for markers that are too similar: any two of them,
    and any one to itself turned, must differ in more than twice the cells that may be misread, whatever quarter turns they have.
    """
    file = read_yaml(path, _File)
    for marker_id, rows in enumerate(file.markers):
        if len(rows) != file.cells or any(len(row) != file.cells or set(row) - {_WHITE, _BLACK} for row in rows):
            shape = f"{file.cells} rows of {file.cells} cells"
            raise Refused(path, f"markers[{marker_id}]: expected {shape}, {_BLACK} for black and {_WHITE} for white")
    white = np.array([[[cell == _WHITE for cell in row] for row in rows] for rows in file.markers])
    _refuse_similar(path, white, file.corrected_cells)
    return white, file.corrected_cells


def _refuse_similar(path: Path, white: NDArray[np.bool_], corrected_cells: int) -> None:
    """Raises Refused where two markers, or two orientations of one, differ in too few cells."""
    needed = 2 * corrected_cells + 1
    flat = white.reshape(len(white), -1)
    for turns in range(4):
        turned = np.rot90(white, turns, axes=(1, 2)).reshape(len(white), -1)
        for marker_id in range(len(white)):
            differing = np.count_nonzero(turned != flat[marker_id], axis=1)
            if turns == 0:
                differing[marker_id] = needed  # a marker is itself
            other = int(np.argmin(differing))
            if differing[other] < needed:
                which = (
                    f"markers {min(marker_id, other)} and {max(marker_id, other)} differ"
                    if other != marker_id
                    else f"marker {marker_id} turned differs"
                )
                raise Refused(
                    path,
                    f"{which} in {differing[other]} cells where corrected_cells: {corrected_cells} needs {needed}",
                    "draw it anew, or correct fewer cells",
                )
