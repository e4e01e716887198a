"""One Gauss-Newton step on everything that the cables' equation and the arm's hold, as one weighted least squares."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from synchronisation.clocks.arm_equation import CAD_ERROR, ArmRows
from synchronisation.clocks.cables import SKEW, CableTerms, ClockRows, Frames
from synchronisation.clocks.unknowns import ClockUnknowns

Array = NDArray[np.float64]

BLOCK = 1.0
"""s: residuals are taken as independent from block to block only"""
FV_WIDE = 0.1
"""N s/rad: no gear motor rubs more, where fv is not given"""
FV_TRUST = 0.05
"""relative, of an fv that is given"""
DELAY_SIGMA = 1e-3
"""s: a row or two of the log pass until a force acts; more is told by nothing else than a fault"""
STRETCH = 1 << 11
"""frames whose products are made at a time: memory does not grow with the recording"""
LIKELY_SKEW = 3e-4
"""ratio: quartz keeps to some 100 ppm; where the motion tells less than that, the clocks' rates are believed alike"""


@dataclass(frozen=True)
class Model:
    """One set of assumptions about what is not known."""

    law: CableTerms = field(default_factory=CableTerms)
    joint_width: float = 0.05
    """rad/s, over which a joint's dry friction turns"""
    cad_scale: float = 1.0
    """times as wrong as usual may masses and springs in neck.yaml be"""


@dataclass(frozen=True)
class System:
    """The equations of a step, of columns scaled by `size`: (J^T J + prior)^-1 (P, P), and what each block of rows pulls."""

    scores: Array
    """J^T residual of each block of BLOCK seconds, (B, P)"""
    inverse: Array
    weight: Array
    size: Array

    def covariance(self, count: int) -> Array:
        """Of the first `count` unknowns, with residuals free to be correlated within blocks of BLOCK seconds, (count, count)."""
        head = self.inverse[:count] / self.size[:count, None]
        return head @ (self.scores.T @ self.scores + np.diag(self.weight)) @ head.T


class _Sums:
    """Products of weighted rows, which need not be there all at once."""

    def __init__(self, columns: int, time: Array) -> None:
        """time: of the frames, s."""
        self._first = time[0]
        self.products = np.zeros((columns, columns))
        self.scores = np.zeros((int((time[-1] - time[0]) // BLOCK) + 1, columns))

    def add(self, J: Array, residual: Array, time: Array) -> None:
        """Of instants with several rows each: J (T, rows, P) of the first P columns, residual (T, rows), time (T,), s."""
        own = J.shape[-1]
        flat = J.reshape(-1, own)
        self.products[:own, :own] += flat.T @ flat
        block = ((time - self._first) // BLOCK).astype(int)
        np.add.at(self.scores[:, :own], np.clip(block, 0, len(self.scores) - 1), np.einsum("trp,tr->tp", J, residual))


def newton_step(
    frames: Frames,
    state: ClockUnknowns,
    model: Model,
    found: ClockRows,
    rows: ArmRows | None,
    whiten: Array,
    fv: Array,
    locked: bool,
) -> tuple[ClockUnknowns, System]:
    """One step on all of a state but its errors, in its order, and the equations it solved. With `locked` the skew stays."""
    m, k = state.own.shape
    d = 3 + len(state.dimensions)
    common = d + m + m * k
    extra = 0 if rows is None else m + rows.by_nuisance.shape[-1]
    sums = _Sums(common + extra, frames.time)
    _add_cables(sums, frames, found, whiten)
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
        joints = joints if len(joints) else np.zeros(extra)
        left = rows.at(replace(state, joints=joints))
        # before friction is known the residual is friction
        torque_error = np.full(left.shape[1], 0.01) if not np.any(joints) else np.std(left, axis=0)
        prior = np.concatenate([prior, np.full(m, np.inf), model.cad_scale * rows.prior])
        centre = np.concatenate([centre, np.zeros(extra)])
        sums.add(_of_arm(rows, m * k) / torque_error[:, None], left / torque_error, rows.time - state.offset)
    now = np.concatenate(
        [
            [state.offset, state.skew / SKEW, state.delay],
            state.dimensions,
            state.fv,
            state.own.ravel(),
            joints[:extra],
        ]
    )
    size = np.sqrt(np.diag(sums.products))
    size = np.where(size > 0, size, 1.0)
    weight = 1 / (prior * size) ** 2
    # unknowns that nothing excites keep their place: a millionth of the data's weight holds them
    told = sums.products / np.outer(size, size) + np.diag(weight + 1e-12)
    inverse = np.asarray(np.linalg.inv(told), dtype=float)
    scores = sums.scores / size
    move = -inverse @ (scores.sum(axis=0) + weight * size * (now - centre)) / size
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
        System(scores, inverse, weight, size),
    )


def _add_cables(sums: _Sums, frames: Frames, found: ClockRows, whiten: Array) -> None:
    """The cables' rows."""
    time = frames.time
    m, k = found.by_own.shape[1:]
    d = 3 + found.by_dimension.shape[2]
    columns = d + m + m * k
    for begin in range(0, len(time), STRETCH):
        some = slice(begin, begin + STRETCH)
        by_offset = found.by_offset[some]
        J = np.zeros((*by_offset.shape, columns))
        J[..., 0] = by_offset
        J[..., 1] = by_offset * (SKEW * (time[some] - frames.middle))[:, None]
        J[..., 2] = found.by_delay[some]
        J[..., 3:d] = found.by_dimension[some]
        for j in range(m):
            J[:, j, d + j] = found.by_fv[some, j]
            J[:, j, d + m + j * k : d + m + (j + 1) * k] = found.by_own[some, j]
        sums.add(whiten[some] @ J, np.einsum("fij,fj->fi", whiten[some], found.residual[some]), time[some])


def _of_arm(rows: ArmRows, own: int) -> Array:
    """Columns of the arm's equation, (K, N, P); it knows neither skew nor the `own` numbers of the cables."""
    none = np.zeros((*rows.by_offset.shape, 1 + own))
    slopes = (rows.by_dimension, rows.by_fv, none[..., 1:], rows.by_fs, rows.by_nuisance)
    first = np.stack([rows.by_offset, none[..., 0], rows.by_delay], axis=-1)
    return np.concatenate([first, *slopes], axis=-1)
