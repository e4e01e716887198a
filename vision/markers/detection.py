"""Markers in a picture: ids and corners."""

from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.dictionaries import opencv_dictionary
from mechanism.description import Markers
from vision.markers.edge_refinement import refine_by_edges

Array = NDArray[np.float64]

OCCLUSION_WIDTHS_PX = (5, 9)
"""px: dark lines up to these widths, a cable across a marker, are filled where a marker is missing (docs/thresholds.md)"""


@dataclass(frozen=True)
class DetectedMarkers:
    """The arm's markers in one picture."""

    corners: dict[int, Array]
    """by marker id, (4, 2), px: top left, top right, bottom right, bottom left of the upright marker"""
    duplicate_ids: tuple[int, ...]
    """ids in view more than once, which `corners` leaves out"""
    foreign_ids: tuple[int, ...]
    """ids that are not on the arm, which `corners` leaves out"""


class MarkerDetector:
    """Detects the arm's markers in grey pictures."""

    def __init__(self, markers: Markers) -> None:
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE  # `refine_by_edges` is more exact
        self._ids = {m.id for m in markers.on_bars}
        family = opencv_dictionary(markers.dictionary)
        self._cells = family.markerSize + 2
        self._detector = cv2.aruco.ArucoDetector(family, parameters)

    def detect_all(self, grey: NDArray[np.uint8], fill_px: int = 0) -> list[tuple[int, Array]]:
        """All markers of the dictionary in a picture, (height, width) uint8: ids and refined corners (4, 2), px.

        They are searched in the picture with dark lines up to `fill_px` px wide filled, and refined in the picture as it is.
        """
        shown = np.ascontiguousarray(grey)
        if fill_px:
            shown = cv2.morphologyEx(
                shown, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (fill_px, fill_px))
            )
        corners, ids, _ = self._detector.detectMarkers(shown)
        marker_ids = [] if ids is None else [int(i) for i in np.ravel(ids)]
        rough = np.array(corners, dtype=float).reshape(-1, 4, 2)
        return list(zip(marker_ids, refine_by_edges(grey, rough, self._cells), strict=True))

    def detect(self, grey: NDArray[np.uint8]) -> DetectedMarkers:
        """The arm's markers in a picture, (height, width) uint8."""
        detections = self.detect_all(grey)
        counts = Counter(i for i, _ in detections)
        unique = {i: c for i, c in detections if i in self._ids and counts[i] == 1}
        for width in OCCLUSION_WIDTHS_PX:
            if counts.keys() >= self._ids:
                break
            filled = self.detect_all(grey, width)
            filled_counts = Counter(i for i, _ in filled)
            unique |= {i: c for i, c in filled if i in self._ids and i not in counts and filled_counts[i] == 1}
            counts |= Counter({i: n for i, n in filled_counts.items() if i in self._ids})
        duplicates = tuple(sorted(i for i, n in counts.items() if n > 1 and i in self._ids))
        return DetectedMarkers(unique, duplicates, tuple(sorted(set(counts) - self._ids)))
