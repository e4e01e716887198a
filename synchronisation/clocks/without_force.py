"""The clock of a log that holds no forces: the cables' elongation stays unknown, and is worth milliseconds of the clock."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synchronisation.clocks.frame_geometry import FrameGeometry
from synchronisation.clocks.gauss_newton_step import BLOCK_S, SKEW_SCALE
from synchronisation.clocks.signals import LogSignals

Array = NDArray[np.float64]

ELONGATION_SIGMA_S = 2e-3
"""s: standard deviation of the offset by elongation, damping, friction and viscosity that are not known (docs/thresholds.md)"""
_STEPS = 6


@dataclass(frozen=True)
class RigidCableFit:
    """Offset and skew of cables that are taken for rigid."""

    offset: float
    """s, at the frames' middle"""
    offset_sigma: float
    skew: float
    skew_sigma: float
    residual: Array
    """(F, M), m"""


def fit_rigid_cables(signals: LogSignals, frames: FrameGeometry, offset: float) -> RigidCableFit:
    """Least squares of travel less winding, with a constant of each cable; from a start of the offset, s."""
    m, skew = frames.winding.shape[1], 0.0
    age = frames.time - frames.middle
    block = ((frames.time - frames.time[0]) // BLOCK_S).astype(int)
    block_starts = np.flatnonzero(np.diff(block, prepend=-1))
    covariance, residual = np.eye(2), np.zeros_like(frames.winding)
    for _ in range(_STEPS):
        at = np.clip(frames.time + offset + skew * age, signals.time[0], signals.time[-1])
        speed = signals.travel(at, 1)
        J = np.zeros((*speed.shape, 2 + m))
        J[..., 0], J[..., 1] = speed, speed * (SKEW_SCALE * age)[:, None]
        for j in range(m):
            J[:, j, 2 + j] = -1.0
        D, r = J.reshape(-1, 2 + m), (signals.travel(at) - frames.winding).ravel()
        step = np.linalg.lstsq(D, -r, rcond=None)[0]
        residual = (r + D @ step).reshape(-1, m)
        offset, skew = offset + float(step[0]), skew + float(SKEW_SCALE * step[1])
        # residuals may be correlated within blocks: covariance by the blocks' scores
        scores = D.reshape(-1, m, 2 + m) * residual[..., None]
        of_blocks = np.add.reduceat(scores.sum(axis=1), block_starts, axis=0)
        inverse = np.linalg.pinv(D.T @ D)
        covariance = inverse @ (of_blocks.T @ of_blocks) @ inverse
    statistical = np.sqrt(np.diag(covariance)[:2]) * [1.0, SKEW_SCALE]
    return RigidCableFit(
        offset=offset,
        offset_sigma=float(np.hypot(statistical[0], ELONGATION_SIGMA_S)),
        skew=skew,
        skew_sigma=float(statistical[1]),
        residual=residual,
    )
