"""Offset and skew from the cables' equation and the arm's, solved together with everything else that these hold.

Both are linearised at the present estimate and solved as one weighted least squares; motor viscosity couples them. Several
models of what is not known are fitted: the first is reported, and the spread of those that explain as well enters its sigma.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from vision.clocks.arm_equation import ArmRows, arm_rows
from vision.clocks.cables import FIRST_ERROR, SKEW, Cables, Frames, Law, Rows, errors_seen, whitening
from vision.clocks.signals import Signals

Array = NDArray[np.float64]

BLOCK = 1.0
"""s: residuals are taken as independent from block to block only"""
FV_WIDE = 0.1
"""N s/rad: no gear motor rubs more, where fv is not given"""
FV_TRUST = 0.05
"""relative, of an fv that is given"""
TOLERANCE = 1e-6
"""s: a step of the offset that ends the search"""
ROUNDS = 12
OUTLIER = 4.0
"""sigma of a whole frame, from which its weight falls"""
AS_WELL = 1.15
"""a model counts if it leaves at most this many times the error that the reported one leaves"""


@dataclass(frozen=True)
class Model:
    """One set of assumptions about what is not known."""

    law: Law = Law()
    joint_width: float = 0.05
    """rad/s, over which a joint's dry friction turns"""
    cad_scale: float = 1.0
    """times as wrong as usual may masses and springs in neck.yaml be"""


LADDER = (
    Model(),
    Model(Law(creep=(1.0, 6.0))),
    Model(Law(powers=4)),
    Model(Law(powers=2, creep=())),
    Model(joint_width=0.15),
    Model(cad_scale=5.0),
)


@dataclass(frozen=True)
class State:
    """All unknowns at once."""

    offset: float
    skew: float
    fv: Array
    """(M,), N s/rad"""
    own: Array
    """each cable's, by its law, (M, K)"""
    joints: Array
    """fs of the motors and the arm equation's nuisances, (M + P,)"""
    model_error: float
    """m, of the cables' law"""
    scale: float
    """true over stated noise of the angles"""
    torque_error: Array
    """(N,), N m, of the arm's equation"""


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


@dataclass(frozen=True)
class Fit:
    """A model's estimate, the equations of its last step, and the residuals of the cables (F, M), m."""

    state: State
    system: System
    residual: Array


@dataclass(frozen=True)
class Fine:
    """The reported fit, with the spread of the models that explain as well in its sigmas."""

    fit: Fit
    offset_sigma: float
    skew_sigma: float
    cables: Cables
    frames: Frames
    models: int
    """how many of the ladder took part"""


def fit_fine(arm: Arm, signals: Signals, frames: Frames, offset: float, fv: Array) -> Fine:
    """Offset (at the frames' middle) and skew, from a start within some 20 ms. fv (M,), N s/rad, NaN where not known."""
    start = Cables(signals, LADDER[0].law)
    state = State(
        offset,
        0.0,
        np.nan_to_num(fv),
        start.start(frames, offset),
        np.zeros(0),
        FIRST_ERROR,
        1.0,
        np.full(arm.N, np.inf),
    )
    first, cables = _settle(arm, signals, frames, state, LADDER[0], start, None, fv)
    rows = _rows(arm, signals, frames, first.state, LADDER[0])
    reported, cables = _settle(arm, signals, frames, first.state, LADDER[0], cables, rows, fv)
    others = []
    for model in LADDER[1:]:
        state = replace(reported.state, own=_carried(reported.state.own, LADDER[0].law, model.law))
        other = cables if model.law == LADDER[0].law else Cables(signals, model.law, cables.tau)
        changed = rows if model.joint_width == LADDER[0].joint_width else rows.with_width(model.joint_width)
        fit, _ = _settle(arm, signals, frames, state, model, other, changed, fv, rounds=2)
        if _unexplained(fit.state) < AS_WELL * _unexplained(reported.state):
            others.append(fit)
    spread = [
        float(np.std([getattr(fit.state, name) for fit in (reported, *others)], ddof=1)) if others else 0.0
        for name in ("offset", "skew")
    ]
    own = np.sqrt(np.diag(reported.system.covariance(2))) * [1.0, SKEW]
    return Fine(
        reported, float(np.hypot(own[0], spread[0])), float(np.hypot(own[1], spread[1])), cables, frames, 1 + len(others)
    )


LINEAR = Law(powers=1, creep=(), damping=False)
"""cables for a first fit to few frames"""


def fit_cables(
    arm: Arm, signals: Signals, frames: Frames, offset: float, fv: Array, law: Law = LINEAR
) -> tuple[Fit, Cables]:
    """The offset around frames.middle from the cables alone, the skew at zero."""
    model = Model(law)
    cables = Cables(signals, model.law)
    own = cables.start(frames, offset)
    state = State(offset, 0.0, np.nan_to_num(fv), own, np.zeros(0), FIRST_ERROR, 1.0, np.full(arm.N, np.inf))
    return _settle(arm, signals, frames, state, model, cables, None, fv, locked=True)


def _unexplained(state: State) -> float:
    return float(state.model_error * np.exp(np.mean(np.log(state.torque_error))))


def _carried(own: Array, old: Law, new: Law) -> Array:
    """Own parameters of one law as a start for another."""
    out = np.zeros((len(own), len(new.names)))
    for k, name in enumerate(new.names):
        if name in old.names:
            out[:, k] = own[:, old.names.index(name)]
    return out


def _rows(arm: Arm, signals: Signals, frames: Frames, state: State, model: Model) -> ArmRows:
    at = frames.time + state.offset + state.skew * (frames.time - frames.middle)
    return arm_rows(arm, signals, at, frames.alpha, model.joint_width, state.offset)


def _settle(
    arm: Arm,
    signals: Signals,
    frames: Frames,
    state: State,
    model: Model,
    cables: Cables,
    rows: ArmRows | None,
    fv: Array,
    rounds: int = ROUNDS,
    locked: bool = False,
) -> tuple[Fit, Cables]:
    """Gauss-Newton steps; weights, and the curves' lag, follow the estimate. With `locked` the skew stays."""
    shrink = np.ones(len(frames.time))
    found, lagged, last = cables.rows(frames, state.offset, state.skew, state.fv, state.own), 0, None
    for step in range(rounds):
        whiten = whitening(frames, state.model_error, state.scale) * shrink[:, None, None]
        before = state.offset
        state, last = _step(frames, state, model, found, rows, whiten, fv, 1e-9 if locked else np.inf)
        found = cables.rows(frames, state.offset, state.skew, state.fv, state.own)
        error, scale = errors_seen(frames, found.residual)
        size = np.sqrt(np.mean(np.einsum("fij,fj->fi", whiten, found.residual) ** 2, axis=1)) / shrink
        shrink = np.minimum(1.0, OUTLIER / np.maximum(size / max(np.median(size), 1e-9), 1e-9)) if step else shrink
        state = replace(state, model_error=error, scale=scale)
        tau = cables.lag(state.own)
        if lagged < 2 and step and np.max(np.abs(tau - cables.tau)) > 3e-4:
            cables, lagged = Cables(signals, model.law, tau), lagged + 1
            found = cables.rows(frames, state.offset, state.skew, state.fv, state.own)
        elif step > 1 and abs(state.offset - before) < TOLERANCE:
            break
    assert last is not None
    return Fit(state, last, found.residual), cables


def _step(
    frames: Frames, state: State, model: Model, found: Rows, rows: ArmRows | None, whiten: Array, fv: Array,
    skew_sigma: float,
) -> tuple[State, System]:
    """One step on all unknowns: (offset, skew, fv, own, joints), and the equations it solved."""
    f, m = frames.winding.shape
    k = state.own.shape[1]
    common = 2 + m + m * k
    J = np.zeros((f, m, common))
    J[..., 0] = found.by_offset
    J[..., 1] = found.by_offset * (SKEW * (frames.time - frames.middle))[:, None]
    for j in range(m):
        J[:, j, 2 + j] = found.by_fv[:, j]
        J[:, j, 2 + m + j * k : 2 + m + (j + 1) * k] = found.by_own[:, j]
    J = (whiten @ J).reshape(f * m, common)
    r = np.einsum("fij,fj->fi", whiten, found.residual).ravel()
    time = np.repeat(frames.time, m)
    known = ~np.isnan(fv)
    if rows is None:  # the cables alone cannot tell viscosity from offset
        fv_sigma = np.where(known, FV_TRUST * np.abs(fv), 1e-9)
    else:
        fv_sigma = np.where(known, np.maximum(FV_TRUST * np.abs(fv), 1e-6), FV_WIDE)
    centre = np.concatenate([[0.0, state.skew / SKEW], np.where(known, np.nan_to_num(fv), 0.0), np.zeros(m * k)])
    prior = np.concatenate([[np.inf, skew_sigma / SKEW], np.maximum(fv_sigma, 1e-9), np.tile(model.law.wide, m)])
    joints = state.joints
    torque_error = state.torque_error
    if rows is not None:
        extra = m + rows.by_nuisance.shape[-1]
        joints = joints if len(joints) else np.zeros(extra)
        left = rows.at(state.offset, state.fv, joints)
        # before friction is known the residual is friction
        torque_error = np.full(left.shape[1], 0.01) if not np.any(joints) else np.std(left, axis=0)
        A = np.concatenate(
            [
                rows.by_offset[..., None],
                np.zeros((*rows.by_offset.shape, 1)),
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
    now = np.concatenate([[state.offset, state.skew / SKEW], state.fv, state.own.ravel(), joints[: len(prior) - common]])
    size = np.linalg.norm(J, axis=0)
    size = np.where(size > 0, size, 1.0)
    J = J / size
    weight = 1 / (prior * size) ** 2
    # unknowns that nothing excites keep their place: a millionth of the data's weight holds them
    inverse = np.linalg.inv(J.T @ J + np.diag(weight + 1e-12))
    move = -inverse @ (J.T @ r + weight * size * (now - centre)) / size
    after = now + move
    return (
        replace(
            state,
            offset=float(after[0]),
            skew=float(SKEW * after[1]),
            fv=after[2 : 2 + m],
            own=after[2 + m : common].reshape(m, k),
            joints=after[common:] if rows is not None else state.joints,
            torque_error=torque_error,
        ),
        System(J, r, time, inverse, weight, size),
    )
