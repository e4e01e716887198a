"""What an arm did before a row, as far as its errors depend on it: how fast joints went lately, and to which side motors turned."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from observation.pose_time import POSE_TIME_S

Array = NDArray[np.float64]

SIDE_TRAVEL_M = 2e-4
"""m of cable that a motor winds in or out from the one side to the other, as with play (docs/thresholds.md)"""


@dataclass(frozen=True)
class RecentMotion:
    """Mean square of the joints' speed, and the motors' sides."""

    mean_square: float
    """(rad/s)^2, forgotten as the pose's error is"""
    sides: Array
    """-1 ... 1, (M,): 1 where a motor last wound in, and has done so for SIDE_TRAVEL_M"""

    def after(self, alpha_d: Array, travel: Array, interval: float) -> "RecentMotion":
        """A row later, at joint speeds (N,), rad/s; travel: of the cables on their motors meanwhile, (M,), m; interval: s."""
        kept = np.exp(-interval / POSE_TIME_S)
        square = float(alpha_d @ alpha_d)
        sides = np.minimum(np.maximum(self.sides + travel / (SIDE_TRAVEL_M / 2), -1.0), 1.0)
        return RecentMotion(square + (self.mean_square - square) * kept, sides)


def no_motion(motors: int) -> RecentMotion:
    """Of an arm that rested, its motors between both sides."""
    return RecentMotion(0.0, np.zeros(motors))
