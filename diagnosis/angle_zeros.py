"""What a marker that is turned against its bar does to the joint angles on both sides of the bar."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def angle_errors_of_bars(joints: int) -> Array:
    """What one radian of each bar's marker, from the base's on, adds to each joint angle, (N + 1, N)."""
    bars = np.eye(joints + 1)
    return bars[:, 1:] - bars[:, :-1]
