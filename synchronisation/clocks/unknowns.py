"""Everything that a clock's equations leave open."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ClockUnknowns:
    """All unknowns at once."""

    offset: float
    skew: float
    delay: float
    """s, by which forces act later than the log says"""
    dimensions: Array
    """(P,), by how much of each the arm's are larger than described"""
    fv: Array
    """(M,), N s/rad"""
    own: Array
    """each cable's, by its law, (M, K)"""
    joints: Array
    """fs of the motors and the arm equation's nuisances, (M + Q,)"""
    model_error: float
    """m, of the cables' law"""
    scale: float
    """true over stated noise of the angles"""
    torque_error: Array
    """(N,), N m, of the arm's equation"""
