"""How strong an arm is: what its cables carry of springs and gravity, against which forces are much or little."""

import numpy as np

from mechanism.arm import Arm
from mechanism.cable_lengths import geometry_of_poses
from mechanism.dynamics import gravity_and_springs

_POSES, _RANGE_RAD = 160, 0.6
_UNLOADED_N = 10.0
"""N, of an arm that lies flat and has no springs"""


def typical_load(arm: Arm) -> float:
    """RMS of the joints' torques at rest over that of the cables' levers, in poses around straight, N.

    Where nothing pulls at the arm, some newtons."""
    alpha = np.random.default_rng(0).uniform(-_RANGE_RAD, _RANGE_RAD, (_POSES, arm.N))
    torque, lever = gravity_and_springs(arm, alpha), geometry_of_poses(arm, alpha).Z
    return float(np.sqrt(np.mean(torque**2) / np.mean(lever**2))) or _UNLOADED_N
