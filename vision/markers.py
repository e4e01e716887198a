"""Markers in a picture: ids and corners."""

from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.dictionaries import dictionary
from mechanism.description import Markers

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Found:
    """Corners by marker id, (4, 2) px: top left, top right, bottom right, bottom left of the upright marker."""

    corners: dict[int, Array]
    duplicate: tuple[int, ...]
    """ids seen more than once, left out"""
    foreign: tuple[int, ...]
    """ids that are not on the arm, left out"""


class Finder:
    """Finds the arm's markers in grey pictures."""

    def __init__(self, markers: Markers) -> None:
        parameters = cv2.aruco.DetectorParameters()
        # a window of half a cell keeps the neighbours' edges out: three times better than the default at 30 px
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        parameters.relativeCornerRefinmentWinSize = 0.5
        parameters.cornerRefinementWinSize = 5
        parameters.cornerRefinementMaxIterations = 50
        parameters.cornerRefinementMinAccuracy = 0.005
        self._ids = {m.id for m in markers.on_bars}
        self._detector = cv2.aruco.ArucoDetector(dictionary(markers.dictionary), parameters)

    def find(self, grey: NDArray[np.uint8]) -> Found:
        """The arm's markers in a picture, (height, width) uint8."""
        corners, ids, _ = self._detector.detectMarkers(np.ascontiguousarray(grey))
        seen = [] if ids is None else [int(i) for i in np.ravel(ids)]
        counts = Counter(seen)
        kept = {
            i: np.asarray(c, dtype=float).reshape(4, 2)
            for i, c in zip(seen, corners, strict=True)
            if i in self._ids and counts[i] == 1
        }
        twice = tuple(sorted(i for i, n in counts.items() if n > 1 and i in self._ids))
        return Found(kept, twice, tuple(sorted(set(seen) - self._ids)))
