"""An arm of which nothing has been identified yet."""

import numpy as np

from identification.estimates import DEFAULT_LAWS
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.friction import CM
from mechanism.machine import Machine

FS_N, K_N_M, CA_N_S_M = 16.8, 8300.0, 0.0
"""means of Fasquelle's tables 1 and 2 for dry friction and stiffness; damping was not identified there"""


def nominal_machine(neck: Neck) -> Machine:
    """Motors and cables like those of Fasquelle's arm, with the viscous friction that neck.yaml knows of."""
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
