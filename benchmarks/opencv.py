"""OpenCV's marker detector alone, with each of its refinements: what ours is held against."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.dictionaries import opencv_dictionary

Find = Callable[[NDArray[np.uint8]], dict[int, NDArray[np.float64]]]

REFINEMENTS = {
    "NONE": cv2.aruco.CORNER_REFINE_NONE,
    "SUBPIX": cv2.aruco.CORNER_REFINE_SUBPIX,
    "CONTOUR": cv2.aruco.CORNER_REFINE_CONTOUR,
    "APRILTAG": cv2.aruco.CORNER_REFINE_APRILTAG,
}


def searching(name: str, refinement: str) -> Find:
    """A function from a whole grey picture to corners (4, 2), px, by id, for a dictionary and one of REFINEMENTS."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = REFINEMENTS[refinement]
    detector = cv2.aruco.ArucoDetector(opencv_dictionary(name), parameters)

    def find(grey: NDArray[np.uint8]) -> dict[int, NDArray[np.float64]]:
        corners, ids, _ = detector.detectMarkers(np.ascontiguousarray(grey))
        found = [] if ids is None else [int(i) for i in np.ravel(ids)]
        return {i: np.asarray(c, dtype=float).reshape(4, 2) for i, c in zip(found, corners, strict=True)}

    return find
