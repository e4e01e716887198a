"""Laws and parameters assumed for an arm of which nothing has been identified yet."""

import numpy as np

from identification.estimates import DEFAULT_LAWS
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.friction import CM
from mechanism.machine import Machine

FS_N, K_N_M, CA_N_S_M = 16.8, 8300.0, 0.0
"""dry friction, stiffness, damping: means of Fasquelle's tables 1 and 2; damping was not identified there and is taken as zero
(docs/thresholds.md)"""


def nominal_machine(neck: Neck) -> Machine:
    """The arm with motors and cables like those of Fasquelle's, and the viscous friction that neck.yaml states."""
    arm = arm_of(neck)
    return Machine(
        arm,
        DEFAULT_LAWS,
        {
            "fs": np.full(arm.M, FS_N),
            "cm": np.array([CM]),
            "fv": np.array([motor.fv or 0.0 for motor in neck.motors]),
            "k": np.full(arm.M, K_N_M),
            "ca": np.full(arm.M, CA_N_S_M),
        },
    )
