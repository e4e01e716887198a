"""Where the board was, view by view."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class BoardPoses:
    """T_camera_board of each view: p_camera = R p_board + t."""

    R: np.ndarray  # shape (n, 3, 3)
    t: np.ndarray  # shape (n, 3), m

    def of(self, index: np.ndarray | Sequence[int]) -> "BoardPoses":
        """The poses of some of the views."""
        return BoardPoses(self.R[index], self.t[index])

    def moved(self, steps: np.ndarray) -> "BoardPoses":
        """Turned from the left by steps[:, :3], rad, and shifted by steps[:, 3:], m; shape (n, 6)."""
        return BoardPoses(Rotation.from_rotvec(steps[:, :3]).as_matrix() @ self.R, self.t + steps[:, 3:])
