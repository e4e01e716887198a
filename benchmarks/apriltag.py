"""AprilTag's own detector, by pyapriltags: what ours is held against."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pyapriltags
from numpy.typing import NDArray

FAMILIES = {"apriltag_36h11": "tag36h11"}
"""its names of the dictionaries that it knows"""


def apriltags(name: str, decimate: float) -> Callable[[NDArray[np.uint8]], list[tuple[int, NDArray[np.float64]]]]:
    """A function from a whole grey picture to ids and corners (4, 2), px, as OpenCV counts both.

    decimate: squares are looked for in a picture so many times smaller, their edges fitted in the whole one.
    """
    detector: Any = pyapriltags.Detector(families=FAMILIES[name], quad_decimate=decimate, refine_edges=1)

    def find(grey: NDArray[np.uint8]) -> list[tuple[int, NDArray[np.float64]]]:
        # its corners run the other way round from the opposite one, and its pixels have their edges at integers
        return [
            (d.tag_id, np.roll(np.asarray(d.corners, dtype=float)[::-1], 2, axis=0) - 0.5)
            for d in detector.detect(grey)
        ]

    return find
