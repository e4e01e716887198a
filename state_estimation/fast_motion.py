"""Motion faster than the knots of the splines can carry: what motors shake the arm by between them.

Each new command and each turn of dry friction shakes a motor, and its cable shakes the arm. The motors' speeds within the rows are
known (see identification/motor_speeds.py), so the arm's accelerations follow from (1) and (42), linear about a pose and without the
slow forces of gravity and springs:

    i w (i w M + Z C Z^T) alpha_w = Z C (rd/R) theta'_w,    C = diag(ca + k / (i w))

Nothing here enters the angles. What the knots cannot carry of it is uncertainty of the derivatives.
"""

import numpy as np
from numpy.typing import NDArray

from mechanism.cable_lengths import Z
from mechanism.dynamics import mass_matrix
from state_estimation.elongation_law import ElongationLaw
from state_estimation.spline import CARRIED

Array = NDArray[np.float64]

SHAKEN_POSES = 4
"""poses, evenly over the recording, that the variance is averaged over"""
MAX_ROWS = 30000
"""rows from the middle of a recording whose speeds are analysed (docs/thresholds.md)"""


def fast_motion_variance(law: ElongationLaw, compliance: Array, alpha: Array, step: float) -> Array | None:
    """Variances of each joint's angle and its two derivatives beyond what knots `step` (s) apart carry, (3, N), SI units.

    compliance: of the cables, (M,), m/N, positive; alpha: angles along the recording, (T, N). None where speeds within the rows are
    not known.
    """
    arm, speeds = law.arm, law.motors.within_rows
    if speeds is None:
        return None
    middle = speeds.mean.shape[1] // 2
    mean = speeds.mean[:, max(0, middle - MAX_ROWS // 2) : middle + MAX_ROWS // 2]
    halves = np.swapaxes(mean, 0, 1).reshape(-1, arm.M)
    half_row = float(np.mean(np.diff(law.motors.time))) / 2
    # a window of mean square one
    window = np.sqrt(8 / 3) * np.hanning(len(halves))[:, None]
    shaken = arm.drum * np.fft.rfft(window * halves, axis=0)
    hertz = np.fft.rfftfreq(len(halves), half_row)
    fast = hertz > CARRIED / step
    w = 2 * np.pi * hertz[fast]
    C = (law.lag + 1 / (1j * w[:, None])) / compliance
    poses = alpha[np.linspace(0, len(alpha) - 1, SHAKEN_POSES + 2).astype(int)[1:-1]]
    variances = []
    for M, slope in zip(mass_matrix(arm, poses), Z(arm, poses), strict=True):
        impedance = 1j * w[:, None, None] * M + (slope * C[:, None, :]) @ slope.T
        speed = np.linalg.solve(impedance, ((C * shaken[fast]) @ slope.T)[..., None])[..., 0]
        derivatives = speed * w[:, None] ** np.array([-1.0, 0.0, 1.0])[:, None, None]
        variances.append(2 * np.sum(np.abs(derivatives) ** 2, axis=1) / len(halves) ** 2)
    return np.mean(variances, axis=0)
