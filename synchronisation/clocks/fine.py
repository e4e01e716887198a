"""Offset and skew from the cables' equation and the arm's, solved together with everything else that these hold.

Both are linearised at the present estimate and solved as one weighted least squares; motor viscosity couples them. Several
models of what is not known are fitted: the first is reported, and the spread of those that explain as well enters its sigma.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from synchronisation.clocks.arm_equation import ArmRows, arm_rows
from synchronisation.clocks.cables import FIRST_ERROR, NEWTON, SKEW, Cables, CableTerms, Frames, errors_seen, whitening
from synchronisation.clocks.newton_step import Model, System, newton_step
from synchronisation.clocks.signals import LogSignals
from synchronisation.clocks.undetermined import NoClue
from synchronisation.clocks.unknowns import ClockUnknowns

Array = NDArray[np.float64]

TOLERANCE = 1e-6
"""s: a step of the offset that ends the search"""
ROUNDS = 12
OUTLIER = 4.0
"""sigma of a whole frame, from which its weight falls"""
SYSTEMATIC = 3e-5
"""s: bias of the offset that filters leave, and what no nuisance says. Over 34 recordings of arms that differ from their
description by up to 1 % in everything errors are 0.9 sigma with it and 1.07 without, over 36 of the benchmark's worlds 0.8"""
SYSTEMATIC_DELAY = 1e-5
"""s: the same of the delay; errors are 0.006 ms where the laws are true, half a sigma"""
ASTRAY = 2.0
"""s: no fit that finds the clock ends so far from where speeds are alike"""
AS_WELL = 1.15
"""a model counts if it leaves at most this many times the error that the reported one leaves"""


LADDER = (
    Model(),
    Model(CableTerms(creep=(1.0, 6.0))),
    Model(CableTerms(powers=4)),
    Model(CableTerms(powers=2, creep=())),
    Model(joint_width=0.15),
    Model(cad_scale=5.0),
)


@dataclass(frozen=True)
class ClockSolution:
    """A model's estimate, the equations of its last step, and the residuals of the cables (F, M), m."""

    state: ClockUnknowns
    system: System
    residual: Array


@dataclass(frozen=True)
class Fine:
    """The reported fit, with the spread of the models that explain as well in its sigmas."""

    fit: ClockSolution
    offset_sigma: float
    skew_sigma: float
    delay_sigma: float
    cables: Cables
    frames: Frames
    models: int
    """how many of the ladder took part"""


def fit_fine(arm: Arm, signals: LogSignals, frames: Frames, offset: float, fv: Array) -> Fine:
    """Offset (at the frames' middle) and skew, from a start within some 20 ms. fv (M,), N s/rad, NaN where not known."""
    start = Cables(signals, LADDER[0].law)
    state = _begun(arm, frames, offset, fv, start)
    first, cables = _settle(arm, signals, frames, state, LADDER[0], start, None, fv)
    rows = _rows(arm, signals, frames, first.state, LADDER[0])
    reported, cables = _settle(arm, signals, frames, first.state, LADDER[0], cables, rows, fv)
    others = []
    for model in LADDER[1:]:
        state = replace(reported.state, own=_carried(reported.state.own, LADDER[0].law, model.law))
        other = cables if model.law == LADDER[0].law else Cables(signals, model.law, cables.tau)
        changed = rows if model.joint_width == LADDER[0].joint_width else rows.with_width(model.joint_width)
        fit, _ = _settle(arm, signals, frames, state, model, other, changed, fv, rounds=2)
        if unexplained(fit.state) < AS_WELL * unexplained(reported.state):
            others.append(fit)
    spread = [
        float(np.std([getattr(fit.state, name) for fit in (reported, *others)], ddof=1)) if others else 0.0
        for name in ("offset", "skew", "delay")
    ]
    own = np.sqrt(np.diag(reported.system.covariance(3))) * [1.0, SKEW, 1.0]
    # the bias may change from one end to the other
    half = float(np.ptp(frames.time)) / 2
    offset_sigma, skew_sigma, delay_sigma = np.hypot(
        np.hypot(own, spread), [SYSTEMATIC, SYSTEMATIC / half, SYSTEMATIC_DELAY]
    )
    return Fine(reported, float(offset_sigma), float(skew_sigma), float(delay_sigma), cables, frames, 1 + len(others))


LINEAR = CableTerms(powers=1, creep=(), damping=False, width=False, inertia=False)
"""cables for a first fit to few frames"""


def fit_cables(
    arm: Arm, signals: LogSignals, frames: Frames, offset: float, fv: Array, law: CableTerms = LINEAR
) -> tuple[ClockSolution, Cables]:
    """The offset around frames.middle from the cables alone, the skew at zero."""
    model = Model(law)
    cables = Cables(signals, model.law)
    state = _begun(arm, frames, offset, fv, cables)
    return _settle(arm, signals, frames, state, model, cables, None, fv, locked=True)


def _begun(arm: Arm, frames: Frames, offset: float, fv: Array, cables: Cables) -> ClockUnknowns:
    """Where a fit begins: the arm as described, and nothing known of its errors."""
    exact, own = np.zeros(frames.by_dimension.shape[2]), cables.start(frames, offset)
    return ClockUnknowns(
        offset, 0.0, 0.0, exact, np.nan_to_num(fv), own, np.zeros(0), FIRST_ERROR, 1.0, np.full(arm.N, np.inf)
    )


def unexplained(state: ClockUnknowns) -> float:
    """What cables and arm leave, as a product of both: models are compared by it."""
    return float(state.model_error * np.exp(np.mean(np.log(state.torque_error))))


def _carried(own: Array, old: CableTerms, new: CableTerms) -> Array:
    """Own parameters of one law as a start for another."""
    out = np.zeros((len(own), len(new.names)))
    for k, name in enumerate(new.names):
        if name in old.names:
            out[:, k] = own[:, old.names.index(name)]
    return out


def _rows(arm: Arm, signals: LogSignals, frames: Frames, state: ClockUnknowns, model: Model) -> ArmRows:
    at = frames.time + state.offset + state.skew * (frames.time - frames.middle)
    rubs = NEWTON * state.own[:, model.law.names.index("h")]
    return arm_rows(arm, signals, at, frames.alpha, model.joint_width, state.offset, rubs)


def _settle(
    arm: Arm,
    signals: LogSignals,
    frames: Frames,
    state: ClockUnknowns,
    model: Model,
    cables: Cables,
    rows: ArmRows | None,
    fv: Array,
    rounds: int = ROUNDS,
    locked: bool = False,
) -> tuple[ClockSolution, Cables]:
    """Gauss-Newton steps; weights, and the curves' lag, follow the estimate. With `locked` the skew stays."""
    shrink = np.ones(len(frames.time))
    found, lagged, last, begun = cables.rows(frames, state), 0, None, state.offset
    for step in range(rounds):
        whiten = whitening(frames, state.model_error, state.scale) * shrink[:, None, None]
        before = state.offset
        state, last = newton_step(frames, state, model, found, rows, whiten, fv, locked)
        found = cables.rows(frames, state)
        error, scale = errors_seen(frames, found.residual)
        size = np.sqrt(np.mean(np.einsum("fij,fj->fi", whiten, found.residual) ** 2, axis=1)) / shrink
        shrink = np.minimum(1.0, OUTLIER / np.maximum(size / max(np.median(size), 1e-9), 1e-9)) if step else shrink
        state = replace(state, model_error=error, scale=scale)
        tau = cables.lag(state.own)
        if lagged < 2 and step and np.max(np.abs(tau - cables.tau)) > 3e-4:
            cables, lagged = Cables(signals, model.law, tau), lagged + 1
            found = cables.rows(frames, state)
        elif step > 1 and abs(state.offset - before) < TOLERANCE:
            break
    if not abs(state.offset - begun) < ASTRAY:
        raise NoClue(
            "sync",
            f"cables and arm would have the clock {state.offset - begun:+.1f} s from where both show the same motion",
            "look at the elongations and forces of this recording, or give both a light",
        )
    assert last is not None
    return ClockSolution(state, last, found.residual), cables
