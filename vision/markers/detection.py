"""Markers in a picture: ids and corners."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.dictionaries import check_marker_id, marker_cells, opencv_dictionary
from mechanism.printed_markers import Markers
from vision.markers.cell_reading import dark_cells, pattern_correlation, read_cells
from vision.markers.edge_refinement import refine_by_edges

Array = NDArray[np.float64]

OCCLUSION_WIDTHS_PX = (4, 6, 9)
"""px: dark lines up to these widths, a cable across a marker, are filled where a marker is missing (docs/thresholds.md)"""
ENLARGED = 2
"""times: small markers are searched in a picture so much larger, where one is missing (docs/thresholds.md)"""
CELL_SAMPLES_PX = 8
"""px of a cell in the upright picture of a marker that its cells are read from (docs/thresholds.md)"""
CELL_MARGIN = 0.3
"""share of a cell, at each of its sides, that is not read in the picture as it is: there small cells are blurred
(docs/thresholds.md)"""
CORRECTED_SHARE = 0.6
"""of the cells by which a dictionary's markers may be told apart though they are wrong: so many may be (docs/thresholds.md)"""
MAX_SQUARES = 100
"""squares of a picture whose cells are read again (docs/thresholds.md)"""
MAX_SIDE_RATIO, MIN_CORNER_SINE = 2.0, 0.3
"""of a marker's opposite sides, and of its corners, as it is seen, where its cells are read again (docs/thresholds.md)"""
MIN_CORRELATION = 0.63
"""correlation of a marker's grey levels with its pattern, below which it is a marker of another dictionary (docs/thresholds.md)"""


@dataclass(frozen=True)
class DetectedMarkers:
    """The arm's markers in one picture."""

    corners: dict[int, Array]
    """by marker id, (4, 2), px: top left, top right, bottom right, bottom left of the upright marker"""
    prints: dict[int, Array]
    """by id of a marker in view more than once, which `corners` leaves out: the corners of each, (n, 4, 2), px"""
    foreign_ids: tuple[int, ...]
    """ids that are not on the arm, which `corners` leaves out"""


class MarkerDetector:
    """Detects the arm's markers in grey pictures."""

    def __init__(self, markers: Markers) -> None:
        self._ids = {m.id for m in markers.on_bars}
        family = opencv_dictionary(markers.dictionary)
        for marker_id in sorted(self._ids):
            check_marker_id(markers.dictionary, marker_id)
        self._dictionary, self._cells = markers.dictionary, family.markerSize + 2
        self._most_wrong = int(CORRECTED_SHARE * family.maxCorrectionBits)
        self._plain, self._fine = (cv2.aruco.ArucoDetector(family, _parameters(fine)) for fine in (False, True))

    def detect_all(self, grey: NDArray[np.uint8], fill_px: int = 0) -> list[tuple[int, Array]]:
        """All markers of the dictionary in a picture, (height, width) uint8: ids and corners (4, 2), px.

        Corners are those of the edges where these are clear, else right to a pixel or two. They are searched in the picture with
        dark lines up to `fill_px` px wide filled, and refined in the picture as it is.
        """
        shown = np.ascontiguousarray(grey)
        if fill_px:
            shown = cv2.morphologyEx(
                shown, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (fill_px, fill_px))
            )
        return self._refined(grey, *self._plain.detectMarkers(shown))

    def detect_small(self, grey: NDArray[np.uint8]) -> list[tuple[int, Array]]:
        """As `detect_all`, also markers of few pixels; five times as slow."""
        shown = cv2.resize(grey, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_CUBIC)
        corners, ids, others = self._fine.detectMarkers(shown)
        # a pixel's middle is a whole number in both pictures
        rough, left = ([(np.asarray(c, dtype=float) + 0.5) / ENLARGED - 0.5 for c in of] for of in (corners, others))
        return self._refined(grey, rough, ids, left)

    def detect(self, grey: NDArray[np.uint8], small: bool = True) -> DetectedMarkers:
        """The arm's markers in a picture, (height, width) uint8; small: whether a missing one may be of few pixels."""
        searches = [partial(self.detect_all, grey, width) for width in (0, *OCCLUSION_WIDTHS_PX)]
        if small:
            searches.append(partial(self.detect_small, grey))
        seen: dict[int, list[Array]] = {}
        foreign_ids: set[int] = set()
        for search in searches:
            if seen.keys() >= self._ids:
                break
            found: dict[int, list[Array]] = {}
            for i, corners in search():
                found.setdefault(i, []).append(corners)
            seen |= {i: c for i, c in found.items() if i in self._ids and len(c) > len(seen.get(i, []))}
            if search is searches[0]:  # the others make more of dark lines and noise
                foreign_ids = found.keys() - self._ids
        return DetectedMarkers(
            corners={i: c[0] for i, c in seen.items() if len(c) == 1},
            prints={i: np.stack(c) for i, c in seen.items() if len(c) > 1},
            foreign_ids=tuple(sorted(foreign_ids)),
        )

    def _refined(
        self, grey: NDArray[np.uint8], corners: Sequence[Any], ids: Any, others: Sequence[Any]
    ) -> list[tuple[int, Array]]:
        """Markers at the corners that a search found, and the arm's in other squares, whose cells it could not read."""
        marker_ids = np.ravel([] if ids is None else ids).astype(int)
        rough = np.array(corners, dtype=float).reshape(-1, 4, 2)
        more_ids, more = self._read_again(grey, others, set(marker_ids))
        marker_ids, rough = np.append(marker_ids, more_ids), np.concatenate([rough, more])
        if not len(marker_ids):
            return []
        black = np.array([marker_cells(self._dictionary, int(i)) for i in marker_ids])
        printed = read_cells(grey, rough, black).is_printed
        marker_ids, rough, black = marker_ids[printed], rough[printed], black[printed]
        refined = refine_by_edges(grey, rough, self._cells)
        found = np.where(np.isnan(refined), rough, refined)
        if not len(found):
            return []
        alike = pattern_correlation(grey, found, black) > MIN_CORRELATION
        return [(int(i), c) for i, c in zip(marker_ids[alike], found[alike], strict=True)]

    def _read_again(
        self, grey: NDArray[np.uint8], others: Sequence[Any], found: set[int]
    ) -> tuple[NDArray[np.intp], Array]:
        """Ids of the arm's markers that were not found and are in one of the other squares, each (4, 2), px, and their corners.

        Where a cell has two pixels, half a pixel of the corners decides how it reads: they are put to the edges first."""
        none = np.zeros(0, dtype=np.intp), np.zeros((0, 4, 2))
        missing = sorted(self._ids - found)
        if not missing:
            return none
        squares = np.array(others, dtype=float).reshape(-1, 4, 2)
        squares = squares[_may_be_square(squares)]
        if not len(squares):
            return none
        # of a picture of noise thousands are found: the largest
        squares = squares[np.argsort(-np.ptp(squares, axis=1).sum(axis=1), kind="stable")[:MAX_SQUARES]]
        refined = refine_by_edges(grey, squares, self._cells)
        refined = np.where(np.isnan(refined), squares, refined)
        squares = np.where(_may_be_square(refined)[:, None, None], refined, squares)
        dark = dark_cells(grey, squares, self._cells)
        patterns = np.array([marker_cells(self._dictionary, i) for i in missing])
        turned = np.stack([np.rot90(patterns, turns, axes=(1, 2)) for turns in range(4)], axis=1)
        wrong = np.count_nonzero(dark[:, None, None] != turned, axis=(3, 4))  # (K, ids, turns)
        ids, corners = [], []
        for of_square, square in zip(wrong, squares, strict=True):
            which, turns = np.unravel_index(int(np.argmin(of_square)), of_square.shape)
            if of_square[which, turns] <= self._most_wrong:
                ids.append(missing[which])
                corners.append(np.roll(square, turns, axis=0))
        return np.array(ids, dtype=np.intp), np.array(corners, dtype=float).reshape(-1, 4, 2)


def _may_be_square(corners: Array) -> NDArray[np.bool_]:
    """Which of (K, 4, 2) have corners far from flat and opposite sides much alike, (K,): what a square looks like."""
    sides = np.roll(corners, -1, axis=1) - corners
    after = np.roll(sides, -1, axis=1)
    turns = sides[..., 0] * after[..., 1] - sides[..., 1] * after[..., 0]
    length = np.linalg.norm(sides, axis=2)
    is_convex = (turns > MIN_CORNER_SINE * length * np.roll(length, -1, axis=1)).all(axis=1)
    return is_convex & (length < MAX_SIDE_RATIO * np.roll(length, 2, axis=1)).all(axis=1)


def _parameters(fine: bool) -> cv2.aruco.DetectorParameters:
    """OpenCV's search; fine: with more thresholds, for a picture that was enlarged."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE  # `refine_by_edges` is more exact
    parameters.perspectiveRemovePixelPerCell = CELL_SAMPLES_PX
    if not fine:
        parameters.perspectiveRemoveIgnoredMarginPerCell = CELL_MARGIN
    else:
        parameters.adaptiveThreshWinSizeStep = 4
        parameters.adaptiveThreshWinSizeMax = 43
    return parameters
