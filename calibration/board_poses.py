"""The pose of the board in each view."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class BoardPoses:
    """T_camera_board of n views: p_camera = R p_board + t."""

    R: np.ndarray  # shape (n, 3, 3)
    t: np.ndarray  # shape (n, 3), m

    def of(self, index: np.ndarray | Sequence[int]) -> "BoardPoses":
        """The poses of some of the views."""
        return BoardPoses(self.R[index], self.t[index])

    def moved(self, steps: np.ndarray) -> "BoardPoses":
        """The poses after steps (n, 6): rotated from the left by the first three numbers, rad, and shifted by the others, m."""
        return BoardPoses(Rotation.from_rotvec(steps[:, :3]).as_matrix() @ self.R, self.t + steps[:, 3:])
