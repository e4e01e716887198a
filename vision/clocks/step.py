"""One Gauss-Newton step on everything that the cables' equation and the arm's hold, as one weighted least squares."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from vision.clocks.arm_equation import CAD_ERROR, ArmRows
from vision.clocks.cables import SKEW, Frames, Law, Rows
from vision.clocks.state import State

Array = NDArray[np.float64]

BLOCK = 1.0
"""s: residuals are taken as independent from block to block only"""
FV_WIDE = 0.1
"""N s/rad: no gear motor rubs more, where fv is not given"""
FV_TRUST = 0.05
"""relative, of an fv that is given"""
DELAY_SIGMA = 1e-3
"""s: a row or two of the log pass until a force acts; more is told by nothing else than a fault"""
LIKELY_SKEW = 3e-4
"""ratio: quartz keeps to some 100 ppm; where the motion tells less than that, the clocks' rates are believed alike"""


@dataclass(frozen=True)
class Model:
    """One set of assumptions about what is not known."""

    law: Law = field(default_factory=Law)
    joint_width: float = 0.05
    """rad/s, over which a joint's dry friction turns"""
    cad_scale: float = 1.0
    """times as wrong as usual may masses and springs in neck.yaml be"""


@dataclass(frozen=True)
class System:
    """The equations of a step: rows (R, P) of columns scaled by `size`, residuals and times of the rows, (J^T J + prior)^-1."""

    J: Array
    residual: Array
    time: Array
    inverse: Array
    weight: Array
    size: Array

    def covariance(self, count: int) -> Array:
        """Of the first `count` unknowns, with residuals free to be correlated within blocks of BLOCK seconds, (count, count)."""
        block = ((self.time - self.time.min()) // BLOCK).astype(int)
        order = np.argsort(block, kind="stable")
        begins = np.flatnonzero(np.diff(block[order], prepend=-1))
        scores = np.add.reduceat((self.J * self.residual[:, None])[order], begins, axis=0)
        head = self.inverse[:count] / self.size[:count, None]
        return head @ (scores.T @ scores + np.diag(self.weight)) @ head.T


def newton_step(
    frames: Frames,
    state: State,
    model: Model,
    found: Rows,
    rows: ArmRows | None,
    whiten: Array,
    fv: Array,
    locked: bool,
) -> tuple[State, System]:
    """One step on all of a state but its errors, in its order, and the equations it solved. With `locked` the skew stays."""
    f, m = frames.winding.shape
    k = state.own.shape[1]
    d = 3 + len(state.dimensions)
    common = d + m + m * k
    J = np.zeros((f, m, common))
    J[..., 0] = found.by_offset
    J[..., 1] = found.by_offset * (SKEW * (frames.time - frames.middle))[:, None]
    J[..., 2] = found.by_delay
    J[..., 3:d] = found.by_dimension
    for j in range(m):
        J[:, j, d + j] = found.by_fv[:, j]
        J[:, j, d + m + j * k : d + m + (j + 1) * k] = found.by_own[:, j]
    J = (whiten @ J).reshape(f * m, common)
    r = np.einsum("fij,fj->fi", whiten, found.residual).ravel()
    time = np.repeat(frames.time, m)
    known = ~np.isnan(fv)
    if rows is None:  # the cables alone cannot tell viscosity and delay from offset
        delay_sigma, wrong, fv_sigma = 1e-9, 1e-9, np.where(known, FV_TRUST * np.abs(fv), 1e-9)
    else:
        delay_sigma, wrong = DELAY_SIGMA, CAD_ERROR
        fv_sigma = np.where(known, np.maximum(FV_TRUST * np.abs(fv), 1e-6), FV_WIDE)
    skew, skew_sigma = (state.skew, 1e-9) if locked else (0.0, LIKELY_SKEW)
    centre = np.concatenate(
        [[0.0, skew / SKEW, 0.0], 0 * state.dimensions, np.where(known, np.nan_to_num(fv), 0.0), np.zeros(m * k)]
    )
    first = [np.inf, skew_sigma / SKEW, delay_sigma]
    prior = np.concatenate([first, np.full(d - 3, wrong), np.maximum(fv_sigma, 1e-9), np.tile(model.law.wide, m)])
    joints = state.joints
    torque_error = state.torque_error
    if rows is not None:
        extra = m + rows.by_nuisance.shape[-1]
        joints = joints if len(joints) else np.zeros(extra)
        left = rows.at(replace(state, joints=joints))
        # before friction is known the residual is friction
        torque_error = np.full(left.shape[1], 0.01) if not np.any(joints) else np.std(left, axis=0)
        A = np.concatenate(
            [
                rows.by_offset[..., None],
                np.zeros((*rows.by_offset.shape, 1)),
                rows.by_delay[..., None],
                rows.by_dimension,
                rows.by_fv,
                np.zeros((*rows.by_offset.shape, m * k)),
                rows.by_fs,
                rows.by_nuisance,
            ],
            axis=-1,
        )
        A = (A / torque_error[:, None]).reshape(-1, common + extra)
        J = np.vstack([np.pad(J, ((0, 0), (0, extra))), A])
        r = np.concatenate([r, (left / torque_error).ravel()])
        time = np.concatenate([time, np.repeat(rows.time - state.offset, left.shape[1])])
        prior = np.concatenate([prior, np.full(m, np.inf), model.cad_scale * rows.prior])
        centre = np.concatenate([centre, np.zeros(extra)])
    now = np.concatenate(
        [
            [state.offset, state.skew / SKEW, state.delay],
            state.dimensions,
            state.fv,
            state.own.ravel(),
            joints[: len(prior) - common],
        ]
    )
    size = np.linalg.norm(J, axis=0)
    size = np.where(size > 0, size, 1.0)
    J = J / size
    weight = 1 / (prior * size) ** 2
    # unknowns that nothing excites keep their place: a millionth of the data's weight holds them
    inverse = np.asarray(np.linalg.inv(J.T @ J + np.diag(weight + 1e-12)), dtype=float)
    move = -inverse @ (J.T @ r + weight * size * (now - centre)) / size
    after = now + move
    return (
        replace(
            state,
            offset=float(after[0]),
            skew=float(SKEW * after[1]),
            delay=float(after[2]),
            dimensions=after[3:d],
            fv=after[d : d + m],
            own=after[d + m : common].reshape(m, k),
            joints=after[common:] if rows is not None else state.joints,
            torque_error=torque_error,
        ),
        System(J, r, time, inverse, weight, size),
    )
