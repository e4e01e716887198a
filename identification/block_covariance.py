"""Covariance of a fit whose residuals are correlated for a while (block jackknife), and errors that a whole recording shares."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.residual_sensitivity import AngleError, ResidualSensitivity
from identification.signals import Signals
from identification.unknowns import Unknowns

Array = NDArray[np.float64]

BLOCK_S = 1.0
"""s: length of a block, beyond which residuals are taken as independent (docs/thresholds.md)"""
MIN_BLOCKS = 40
"""blocks of a fit; of shorter recordings the blocks are shorter (docs/thresholds.md)"""
MIN_EFFECTIVE_BLOCKS = 3.0
"""effective number of blocks below which a sigma is taken as that of three: fewer do not determine one (docs/thresholds.md)"""


@dataclass(frozen=True)
class BlockSums:
    """Sums of the estimating equations over each block: instruments times residuals (B, P), and times the Jacobian (B, P, P)."""

    gradient: Array
    slope: Array


def block_sums(instruments: Array, residual: Array, jacobian: Array, length: int) -> BlockSums:
    """Sums over blocks of `length` rows of one recording; instruments and Jacobian (C, S, P), residuals (C, S), all whitened."""
    blocks = [slice(begin, begin + length) for begin in range(0, residual.shape[1], length)]
    flat = [(instruments[:, b].reshape(-1, instruments.shape[2]), b) for b in blocks]
    gradient = [z.T @ residual[:, b].ravel() for z, b in flat]
    slope = [z.T @ jacobian[:, b].reshape(-1, jacobian.shape[2]) for z, b in flat]
    return BlockSums(np.array(gradient), np.array(slope))


def jackknife_influence(blocks: BlockSums, total: Array, free: NDArray[np.bool_], size: Array) -> Array:
    """By how much the parameters would change without each block, (B, P); their sum of squares is the jackknife's covariance.

    total: slope of all blocks and priors, (P, P). Parameters that are not `free` stay. size: scales of the parameters, (P,); a
    direction that one block alone determines is left out.
    """
    out = np.zeros_like(blocks.gradient)
    chosen = np.ix_(free, free)
    scale = np.outer(size[free], size[free])
    without_block = (total - blocks.slope)[:, *chosen] * scale
    inverse = np.linalg.pinv(without_block, rcond=1e-13)
    out[:, free] = np.einsum("bpq,bq->bp", inverse, blocks.gradient[:, free] * size[free]) * size[free]
    count = len(out)
    return out * np.sqrt((count - 1) / count)


def student_inflated(influences: Array) -> Array:
    """Influences (B, P), larger where few blocks carry the information: a sigma that few blocks determine is itself uncertain.

    With normal influences of one variance, n of them effective, the squares v have (sum v)^2 / sum v^2 = (n + 2) / 3. An error
    over a sigma that n of them determine follows Student's t, of variance n / (n - 2).
    """
    v = influences**2
    n = 3 * v.sum(axis=0) ** 2 / np.maximum(np.sum(v**2, axis=0), np.finfo(float).tiny) - 2
    n = np.maximum(n, MIN_EFFECTIVE_BLOCKS)
    return influences * np.sqrt(n / (n - 2))


def shared_error_residuals(s: Signals, u: Unknowns, p: Array, recording: int) -> Array:
    """Change of the residuals, (C, S, E), by one sigma of each error that all rows share.

    Those of clock, skew, each joint's angle, and of the law of cables that the angles follow from."""
    delay = float(u.get(p, "delay", recording)[0])
    sensitivity = ResidualSensitivity(s, u.laws, u.values(p, recording), u.get(p, "x0", recording), delay)
    from_middle = s.time[s.low_pass.kept] - s.time.mean()
    errors = [sensitivity.error_of_lag(s.clock_sigma[0]), sensitivity.error_of_lag(s.clock_sigma[1] * from_middle)]
    errors += [AngleError(sigma * np.eye(s.arm.N)[i]) for i, sigma in enumerate(s.angle_sigma)]
    changes = [sensitivity.residual_change(angle_error=error) for error in errors]
    for alpha in sensitivity.errors_by_cables(s):
        change = sensitivity.residual_change(angle_error=AngleError(alpha))
        change[: s.arm.M] = 0.0  # the motors' equations have elongations by vision alone
        changes.append(change)
    return np.stack(changes, axis=-1)
