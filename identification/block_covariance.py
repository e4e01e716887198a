"""How far a fit may be off: residuals that stay alike for a while, and errors that a whole recording shares."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.residual_sensitivity import ResidualSensitivity, AngleError
from identification.signals import Signals
from identification.unknowns import Unknowns

Array = NDArray[np.float64]

BLOCK_S = 1.0
MIN_BLOCKS = 40
"""shorter recordings have shorter blocks"""
MIN_EFFECTIVE_BLOCKS = 3.0
"""fewer blocks than that tell no sigma: it is taken as that of three"""


@dataclass(frozen=True)
class BlockSums:
    """Each block's share of the estimating equations: instruments times residuals (B, P), and times columns (B, P, P)."""

    pull: Array
    slope: Array


def block_sums(instruments: Array, residual: Array, jacobian: Array, length: int) -> BlockSums:
    """Blocks of `length` rows from instruments and columns (C, S, P) and residuals (C, S) of one recording, all whitened."""
    begins = range(0, residual.shape[1], length)
    parts = [slice(begin, begin + length) for begin in begins]
    flat = [(instruments[:, b].reshape(-1, instruments.shape[2]), b) for b in parts]
    pull = [z.T @ residual[:, b].ravel() for z, b in flat]
    slope = [z.T @ jacobian[:, b].reshape(-1, jacobian.shape[2]) for z, b in flat]
    return BlockSums(np.array(pull), np.array(slope))


def jackknife_influence(blocks: BlockSums, total: Array, free: NDArray[np.bool_], size: Array) -> Array:
    """By how much the parameters would change without each block, (B, P); their sum of squares is the jackknife's covariance.

    total: the whole slope, (P, P). Parameters that are not `free` stay; a direction that one block alone tells is left at that.
    """
    out = np.zeros_like(blocks.pull)
    chosen = np.ix_(free, free)
    scale = np.outer(size[free], size[free])
    left = (total - blocks.slope)[:, *chosen] * scale
    inverse = np.linalg.pinv(left, rcond=1e-13)
    out[:, free] = np.einsum("bpq,bq->bp", inverse, blocks.pull[:, free] * size[free]) * size[free]
    count = len(out)
    return out * np.sqrt((count - 1) / count)


def student_inflated(influences: Array) -> Array:
    """Influences (B, P), the larger the fewer blocks count: what these leave unknown of a sigma is the estimate's to bear, (B, P).

    Squares v of n alike and normal influences have (sum v)^2 / sum v^2 = (n + 2) / 3. An error over a sigma that n of them tell is
    Student's, of variance n / (n - 2).
    """
    v = influences**2
    n = 3 * v.sum(axis=0) ** 2 / np.maximum(np.sum(v**2, axis=0), np.finfo(float).tiny) - 2
    n = np.maximum(n, MIN_EFFECTIVE_BLOCKS)
    return influences * np.sqrt(n / (n - 2))


def shared_error_residuals(s: Signals, u: Unknowns, p: Array, recording: int) -> Array:
    """What one sigma of each error that all rows share does to the residuals, (C, S, E): clock, skew, each joint's angle."""
    slow = ResidualSensitivity(s, u, p, recording)
    age = s.time[s.low_pass.kept] - s.time.mean()
    moves = [slow.late(s.clock_sigma[0]), slow.late(s.clock_sigma[1] * age)]
    moves += [AngleError(sigma * np.eye(s.arm.N)[i]) for i, sigma in enumerate(s.angle_sigma)]
    return np.stack([slow.change(turned=move) for move in moves], axis=-1)
