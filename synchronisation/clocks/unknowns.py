"""Everything that the clock's equations leave open."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ClockUnknowns:
    """One estimate of all unknowns: the clock, and the nuisances of the cables' equation and of the arm's."""

    offset: float
    """s, at the frames' middle"""
    skew: float
    """ratio by which the log's clock runs faster than the camera's"""
    delay: float
    """s, by which forces act later than the log says"""
    geometry_errors: Array
    """(P,): by how much each number of the arm's geometry is larger than described, relative, rad of an angle's zero"""
    fv: Array
    """(M,), N s/rad: viscosity of the motors"""
    cable_parameters: Array
    """(M, K): parameters of each cable, in the order of its law's names"""
    arm_parameters: Array
    """(M + Q,): fs of the motors, N, then the nuisances of the arm's equation; empty as long as that is not used"""
    cable_error: Array
    """(M,), m: standard deviation of what each cable's law does not explain"""
    rest_error: Array
    """(M,), m: standard deviation of what more is not explained while a cable's motor is at rest"""
    noise_scale: float
    """true over stated standard deviation of the angles"""
    torque_errors: Array
    """(2 N + M,): standard deviations of what the arm's equation does not explain: of each joint, N m, of each in rows in which it
    may be held, N m, and of each motor's force, N; empty as long as that is not used"""
    torque_misfit: float
    """N m: what all these leave together of one joint's row, as the likelihood has it"""

    def cable_errors(self, at_rest: NDArray[np.bool_]) -> Array:
        """Standard deviation of what the cables' law does not explain, (F, M), m, of frames in which motors are at rest, (F, M)."""
        return np.hypot(self.cable_error, np.where(at_rest, self.rest_error, 0.0))
