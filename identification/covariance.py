"""How far a fit may be off: residuals that stay alike for a while, and errors that a whole recording shares."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.residuals import delayed, forces
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.cable_lengths import Z, lengths
from mechanism.dynamics import terms

Array = NDArray[np.float64]

BLOCK_S = 1.0
LEAST_BLOCKS = 40
"""shorter recordings have shorter blocks"""


@dataclass(frozen=True)
class Blocks:
    """Each block's share of the estimating equations: instruments times residuals (B, P), and times columns (B, P, P)."""

    pull: Array
    slope: Array


def in_blocks(instruments: Array, residual: Array, jacobian: Array, length: int) -> Blocks:
    """Blocks of `length` rows from instruments and columns (C, S, P) and residuals (C, S) of one recording, all whitened."""
    begins = range(0, residual.shape[1], length)
    parts = [slice(begin, begin + length) for begin in begins]
    flat = [(instruments[:, b].reshape(-1, instruments.shape[2]), b) for b in parts]
    pull = [z.T @ residual[:, b].ravel() for z, b in flat]
    slope = [z.T @ jacobian[:, b].reshape(-1, jacobian.shape[2]) for z, b in flat]
    return Blocks(np.array(pull), np.array(slope))


def influence(blocks: Blocks, total: Array, free: NDArray[np.bool_], size: Array) -> Array:
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


def shared_errors(s: Signals, u: Unknowns, p: Array, recording: int) -> Array:
    """What one sigma of each error that all rows share does to the residuals, (C, S, E): clock, skew, each joint's angle.

    Slopes are taken at the filter's rows: these signals are slow, only the forces are filtered.
    """
    at = s.low_pass.kept
    m, n = s.arm.M, s.arm.N
    values, x0 = u.values(p), u.get(p, "x0", recording)
    base = forces(s, u.laws, values, x0)
    net = s.low_pass(
        np.ascontiguousarray((delayed(s, float(u.get(p, "delay", recording)[0])) - s.inertial - base.rub).T)
    ).T
    alpha, alpha_d, alpha_dd = s.alpha[at], s.alpha_d[at], s.alpha_dd[at]
    jerk = np.gradient(s.alpha_dd, s.step, axis=0)[at]
    age = (s.time[at] - s.time.mean())[:, None]
    moves = [(e * alpha_d, e * alpha_dd, e * jerk) for e in (s.clock_sigma[0], s.clock_sigma[1] * age)]
    still = np.zeros_like(alpha)
    moves += [(sigma * np.eye(n)[i] + still, still, still) for i, sigma in enumerate(s.angle_sigma)]
    within = replace(
        s, x=s.x[at], x_d=s.x_d[at], length=s.length[at], alpha_d=alpha_d, theta_d=s.theta_d[at], wrap=s.wrap[at]
    )
    here = forces(within, u.laws, values, x0)
    out = np.zeros((m + n, len(at), len(moves)))
    jacobian, load, length = Z(s.arm, alpha), _load(s, alpha, alpha_d, alpha_dd), lengths(s.arm, alpha)
    for e, (d, d_d, d_dd) in enumerate(moves):
        if not np.any(d):
            continue
        moved = Z(s.arm, alpha + d)
        x = within.x + lengths(s.arm, alpha + d) - length
        x_d = within.x_d - np.einsum("tij,ti->tj", moved, alpha_d + d_d) + np.einsum("tij,ti->tj", jacobian, alpha_d)
        other = forces(replace(within, x=x, x_d=x_d, alpha_d=alpha_d + d_d), u.laws, values, x0)
        out[:m, :, e] = (here.pull - other.pull).T
        change = np.einsum("tij,tj->ti", moved - jacobian, net) - _load(s, alpha + d, alpha_d + d_d, alpha_dd + d_dd)
        out[m:, :, e] = (change + load + here.resist - other.resist).T
    return out


def _load(s: Signals, alpha: Array, alpha_d: Array, alpha_dd: Array) -> Array:
    k = terms(s.arm, alpha, alpha_d)
    return np.einsum("tij,tj->ti", k.M, alpha_dd) + k.c + k.g
