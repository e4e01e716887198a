"""Marker dictionaries by name: OpenCV's predefined ones in lower case, and those of the folder `marker_dictionaries`.

OpenCV's AprilTag patterns are turned by 180 degrees against AprilTag's own drawings. What counts here is OpenCV's
orientation: the x axis of a marker points right in its drawing by `marker_cells`.
"""

from functools import cache
from pathlib import Path

import cv2
import numpy as np

from calibration.dictionary_file import dictionary_files, read_dictionary
from xneck_foundation.errors import Refused, one_of
from xneck_foundation.spelling import valid_words


@cache
def _predefined() -> dict[str, int]:
    """OpenCV's constants by the names of their dictionaries."""
    names: dict[str, int] = {}
    for constant in dir(cv2.aruco):
        if constant.startswith("DICT_"):
            name = constant.removeprefix("DICT_").lower()
            name = name if name.startswith(("apriltag", "aruco")) else f"aruco_{name}"
            names[name] = getattr(cv2.aruco, constant)
    return names


def dictionary_names() -> list[str]:
    """All valid names, such as aruco_5x5_100 and apriltag_36h11."""
    return sorted({*_predefined(), *dictionary_files()})


def opencv_dictionary(name: str, where: str = "dictionary") -> cv2.aruco.Dictionary:
    """The dictionary of that name in OpenCV's form; raises Refused with the valid names for an unknown one."""
    one_of(where, name, dictionary_names(), "dictionary")
    file = dictionary_files().get(name)
    if file is None:
        return cv2.aruco.getPredefinedDictionary(_predefined()[name])
    if name in _predefined():
        raise Refused(file, "OpenCV has a dictionary of this name", "rename the file")
    return _from_file(file)


@cache
def _from_file(path: Path) -> cv2.aruco.Dictionary:
    """OpenCV's form of a dictionary file."""
    white, corrected_cells = read_dictionary(path)
    markers = [cv2.aruco.Dictionary.getByteListFromBits(marker.astype(np.uint8)) for marker in white]
    return cv2.aruco.Dictionary(np.concatenate(markers), white.shape[1], corrected_cells)


def dictionary_size(name: str) -> int:
    """How many markers the dictionary has; their ids are 0 .. size - 1."""
    return int(opencv_dictionary(name).bytesList.shape[0])


def check_marker_id(name: str, marker_id: int) -> None:
    """Raises Refused where the dictionary has no marker of that id."""
    if not 0 <= marker_id < dictionary_size(name):
        raise Refused(f"marker {marker_id}", f"{name} has the ids 0 to {dictionary_size(name) - 1}")


def check_dictionary(name: str, needed: int) -> str:
    """The name of a dictionary with `needed` markers or more; raises ValueError, for validators."""
    if name not in dictionary_names():
        raise ValueError(f"unknown dictionary, {valid_words(name, dictionary_names())}")
    if needed > dictionary_size(name):
        raise ValueError(f"has {dictionary_size(name)} markers, the board needs {needed}")
    return name


def is_upside_down(name: str) -> bool:
    """Is OpenCV's drawing of these markers turned by 180 degrees against that of their makers?"""
    return name in _predefined() and name.startswith("apriltag")


def marker_cells(name: str, marker_id: int, border: int = 1) -> np.ndarray:
    """The marker as cells, True = black, its black border of `border` cells included; first row on top.

    Shape (n + 2 border, n + 2 border) for markers of n x n bits.
    """
    check_marker_id(name, marker_id)
    family = opencv_dictionary(name)
    return cv2.aruco.generateImageMarker(family, marker_id, family.markerSize + 2 * border, borderBits=border) == 0
