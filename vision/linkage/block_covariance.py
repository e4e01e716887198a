"""Covariance of what all frames share, where corner errors of neighbouring frames are correlated.

A compressed video repeats its errors from frame to frame until the next key frame, or the marker has moved on. So the frames'
scores are summed over blocks of consecutive frames, longer than errors last, and the covariance follows from their scatter
from block to block (the sandwich clustered by blocks, Liang and Zeger 1986; CR2 of Bell and McCaffrey 2002). Few blocks
understate it, so a share of what white noise would give is added. They also tell little of how many directions are correlated:
the scatter is drawn towards white noise of the same size by as much as the blocks leave open (Ledoit and Wolf 2004).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MIN_BLOCK_FRAMES = 45
"""frames of a block at least: a codec's errors last for half a second to a second, at 30 frames/s (docs/thresholds.md)"""
MAX_BLOCKS = 40
"""blocks that a recording is cut into at most (docs/thresholds.md)"""
WHITE_NOISE_BLOCKS = 3.0
"""number of blocks with which white noise adds half of its variance to what the blocks' scatter gives (docs/thresholds.md)"""
MAX_LEVERAGE = 0.9
"""greatest share of a direction's information that a block is credited with: the rest corrects its score (docs/thresholds.md)"""


def frame_blocks(frames: int) -> NDArray[np.intp]:
    """The block to which each frame of a recording belongs, shape (F,), numbered from 0 without gaps."""
    count = int(np.clip(frames // MIN_BLOCK_FRAMES, 1, MAX_BLOCKS))
    return np.arange(frames) * count // max(frames, 1)


def clustered_covariance(
    information: Array, score: Array, prior: Array, variance: float, wider: Array | float = 1.0
) -> Array:
    """Covariance (p, p) of p parameters estimated by least squares.

    information (B, p, p), score (B, p): normal equations of each block at the solution, not yet divided by `variance`, that of
    white noise; prior (p,): 1/sigma^2 of each parameter's prior; wider (p,): variance of what is known of it over that sigma^2.
    With one block it is the covariance for white noise.
    """
    whole = information.sum(axis=0) + np.diag(prior * variance)
    scale = np.sqrt(np.diag(whole))
    half = np.linalg.cholesky(whole / np.outer(scale, scale))
    to_unit = np.linalg.inv(half) / scale  # unknowns in which the information is one
    share = to_unit @ information @ to_unit.T
    prior_share = to_unit @ np.diag(prior * wider * variance) @ to_unit.T
    white = share.sum(axis=0)
    informed = np.trace(share, axis1=1, axis2=2) > 1e-12
    if informed.sum() < 2:
        return variance * to_unit.T @ (white + prior_share) @ to_unit
    z = score[informed] @ to_unit.T / np.sqrt(variance)
    # the fit has already reduced every block's score by the block's own leverage
    leverage, directions = np.linalg.eigh(share[informed])
    correction = 1 / np.sqrt(1 - np.clip(leverage, 0.0, MAX_LEVERAGE))
    z = np.einsum("bik,bk,bjk,bj->bi", directions, correction, directions, z)
    scatter = _shrunk(z, white)
    middle = scatter + WHITE_NOISE_BLOCKS / (WHITE_NOISE_BLOCKS + informed.sum()) * white + prior_share
    return variance * to_unit.T @ middle @ to_unit


def _shrunk(z: Array, white: Array) -> Array:
    """Scatter of blocks' scores z, (B, p), drawn towards that of white noise, (p, p), of the same size, or larger."""
    blocks, scatter = len(z), z.T @ z
    target = white * max(1.0, float(np.trace(scatter) / np.trace(white)))
    distance = float(np.sum((scatter - target) ** 2))
    squares = np.sum(z**2, axis=1)
    # the sum over blocks of |B z z' - scatter|^2, over B^2: the variance of the scatter's entries
    chance = float(np.sum(squares**2) - np.sum(scatter**2) / blocks)
    share = min(1.0, chance / distance) if distance > 0 else 1.0
    return share * target + (1 - share) * scatter
