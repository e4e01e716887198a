"""The clock of a log that holds no forces: what cables stretch stays unknown, and pulls the clock by milliseconds."""

import numpy as np
from numpy.typing import NDArray

from synchronisation.clocks.cables import SKEW, Frames
from synchronisation.clocks.signals import LogSignals

Array = NDArray[np.float64]

UNEXPLAINED = 2e-3
"""s: what elasticity, damping, friction and viscosity together pull the clock by; each alone is worth 1.5 to 7 ms of either sign,
and together 0.6 to 1.4 ms were seen"""
ROUNDS = 6


def fit_without_force(signals: LogSignals, frames: Frames, offset: float) -> tuple[float, float, float, float, Array]:
    """Offset, its sigma, skew, its sigma, and what is left (F, M), m, with a constant for each cable."""
    m, skew = frames.winding.shape[1], 0.0
    away = frames.time - frames.middle
    covariance, left = np.eye(2), np.zeros_like(frames.winding)
    for _ in range(ROUNDS):
        at = np.clip(frames.time + offset + skew * away, signals.time[0], signals.time[-1])
        slope = signals.travel(at, 1)
        J = np.zeros((*slope.shape, 2 + m))
        J[..., 0], J[..., 1] = slope, slope * (SKEW * away)[:, None]
        for j in range(m):
            J[:, j, 2 + j] = -1.0
        D, r = J.reshape(-1, 2 + m), (signals.travel(at) - frames.winding).ravel()
        step = np.linalg.lstsq(D, -r, rcond=None)[0]
        left = (r + D @ step).reshape(-1, m)
        offset, skew = offset + float(step[0]), skew + float(SKEW * step[1])
        scores = D.reshape(-1, m, 2 + m) * left[..., None]
        block = ((frames.time - frames.time[0]) // 1.0).astype(int)
        summed = np.add.reduceat(scores.sum(axis=1), np.flatnonzero(np.diff(block, prepend=-1)), axis=0)
        bread = np.linalg.pinv(D.T @ D)
        covariance = bread @ (summed.T @ summed) @ bread
    own = np.sqrt(np.diag(covariance)[:2]) * [1.0, SKEW]
    return offset, float(np.hypot(own[0], UNEXPLAINED)), skew, float(own[1]), left
