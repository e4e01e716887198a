"""Markers in a picture: ids and corners."""

from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.dictionaries import dictionary
from mechanism.description import Markers
from vision.markers.edges import refine

Array = NDArray[np.float64]

THIN = (5, 9)
"""px: dark lines narrower than this, a cable across a marker, are filled where a marker is missing"""


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
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE  # `refine` does it better
        self._ids = {m.id for m in markers.on_bars}
        family = dictionary(markers.dictionary)
        self._cells = family.markerSize + 2
        self._detector = cv2.aruco.ArucoDetector(family, parameters)

    def detections(self, grey: NDArray[np.uint8], thin: int = 0) -> list[tuple[int, Array]]:
        """All markers of the dictionary in a picture, (height, width) uint8: ids and refined corners (4, 2), px.

        They are looked for where dark lines up to `thin` px are filled, and refined in the picture as it is.
        """
        shown = np.ascontiguousarray(grey)
        if thin:
            shown = cv2.morphologyEx(shown, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (thin, thin)))
        corners, ids, _ = self._detector.detectMarkers(shown)
        seen = [] if ids is None else [int(i) for i in np.ravel(ids)]
        found = np.array(corners, dtype=float).reshape(-1, 4, 2)
        return list(zip(seen, refine(grey, found, self._cells), strict=True))

    def find(self, grey: NDArray[np.uint8]) -> Found:
        """The arm's markers in a picture, (height, width) uint8."""
        seen = self.detections(grey)
        counts = Counter(i for i, _ in seen)
        kept = {i: c for i, c in seen if i in self._ids and counts[i] == 1}
        for thin in THIN:
            if counts.keys() >= self._ids:
                break
            filled = self.detections(grey, thin)
            again = Counter(i for i, _ in filled)
            kept |= {i: c for i, c in filled if i in self._ids and i not in counts and again[i] == 1}
            counts |= Counter({i: n for i, n in again.items() if i in self._ids})
        twice = tuple(sorted(i for i, n in counts.items() if n > 1 and i in self._ids))
        return Found(kept, twice, tuple(sorted(set(counts) - self._ids)))
