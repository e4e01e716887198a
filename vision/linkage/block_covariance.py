"""Covariance of what all frames share, when corner errors of neighbouring frames go together.

A compressed video repeats its errors from frame to frame until the next key frame, or the marker has moved on. So the frames'
scores are summed over blocks of consecutive frames, longer than errors last, and their scatter from block to block is
taken for what it is (the sandwich clustered by blocks, Liang and Zeger 1986; CR2 of Bell and McCaffrey 2002). What few
blocks leave open is filled with a share of what white noise would give.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_FRAMES = 45
"""of a block: half a second to a second is how long errors of a codec last at 30 frames/s"""
MOST_BLOCKS = 40
FEW = 3.0
"""blocks; so many leave half of the variance of white noise open"""
MOST_LEVERAGE = 0.9
"""of a block in a direction; more would be one block's say against no other's"""


def blocks_of(frames: int) -> NDArray[np.intp]:
    """Number of the block of each of a recording's frames, (F,), from 0 on without gaps."""
    count = int(np.clip(frames // LEAST_FRAMES, 1, MOST_BLOCKS))
    return np.arange(frames) * count // max(frames, 1)


def clustered(information: Array, score: Array, prior: Array, variance: float) -> Array:
    """Covariance (p, p) of numbers estimated by least squares.

    information (B, p, p), score (B, p): normal equations of each block at the solution, not yet divided by the variance of white
    noise; prior (p,): 1/sigma^2 of what was known beforehand. With one block it is the covariance of white noise.
    """
    whole = information.sum(axis=0) + np.diag(prior * variance)
    scale = np.sqrt(np.diag(whole))
    half = np.linalg.cholesky(whole / np.outer(scale, scale))
    to_unit = np.linalg.inv(half) / scale  # unknowns in which the information is one
    share = to_unit @ information @ to_unit.T
    beforehand = to_unit @ np.diag(prior * variance) @ to_unit.T
    white = share.sum(axis=0)
    live = np.trace(share, axis1=1, axis2=2) > 1e-12
    if live.sum() < 2:
        return variance * to_unit.T @ to_unit
    z = score[live] @ to_unit.T / np.sqrt(variance)
    # the fit has taken its part out of every block's score
    leverage, ways = np.linalg.eigh(share[live])
    given = 1 / np.sqrt(1 - np.clip(leverage, 0.0, MOST_LEVERAGE))
    z = np.einsum("bik,bk,bjk,bj->bi", ways, given, ways, z)
    scatter = z.T @ z
    middle = scatter + FEW / (FEW + live.sum()) * white + beforehand
    return variance * to_unit.T @ middle @ to_unit
