"""Gauss-Newton fit of a clock: steps on the cables' equation, with or without the arm's, until the offset settles."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.motor_rest import MIN_OF_A_CLASS, error_at_rest
from synchronisation.clocks.arm_equation import ArmRows, HeldMotors
from synchronisation.clocks.cable_equation import CableEquation, CableRows, CableTerms
from synchronisation.clocks.frame_geometry import FrameGeometry
from synchronisation.clocks.gauss_newton_step import (
    ModelAssumptions,
    NormalEquations,
    Step,
    StepRows,
    gauss_newton_step,
)
from synchronisation.clocks.signals import LogSignals
from synchronisation.clocks.undetermined import ClockUndetermined
from synchronisation.clocks.unknowns import ClockUnknowns

Array = NDArray[np.float64]

OFFSET_TOLERANCE_S = 1e-6
"""s: a fit ends with a step that moves the offset by less"""
MAX_STEPS = 12
MIN_STEP = 1 / 64
"""share of a step that is taken in any case"""
MAX_RISE = 1.01
"""ratio by which a step may raise what it should lessen: its slopes hold some terms to first order only"""
OUTLIER_SIGMA = 4.0
"""size of a whole frame's residual, over the median one, beyond which its weight falls (docs/thresholds.md)"""
MAX_OFFSET_CHANGE_S = 2.0
"""s: a fit that moves the offset further from the coarse alignment has not found the clock (docs/thresholds.md)"""
INITIAL_CABLE_ERROR_M = 3e-5
"""m: error of the cables' law before anything is fitted"""
LAG_TOLERANCE_S = 3e-4
"""s: a larger change of a cable's lag makes its curves anew"""
MAX_LAG_UPDATES = 5
LINEAR = CableTerms(powers=1, creep=(), damping=False, friction_forms=False, inertia=False)
"""law of the cables for a first fit to few frames"""


@dataclass(frozen=True)
class ClockProblem:
    """What a clock is fitted to: N joints, M cables, F frames."""

    signals: LogSignals
    frames: FrameGeometry
    fv: Array
    """(M,), N s/rad: motor viscosity, NaN where not known"""


@dataclass(frozen=True)
class ClockSolution:
    """The estimate of one set of assumptions."""

    unknowns: ClockUnknowns
    equations: NormalEquations
    """of the last step"""
    cables: CableEquation
    """with the lag that was found"""
    rows: CableRows
    """of the cables' equation"""

    @property
    def residual(self) -> Array:
        """Of the cables' equation, (F, M), m."""
        return self.rows.residual

    @property
    def residual_rms(self) -> Array:
        """Of each cable, (M,), m, but for frames in which friction holds its motor by a force that is not known."""
        held = self.rows.at_rest & self.held.motors
        return np.sqrt(np.mean(self.residual**2, axis=0, where=~held))

    @property
    def held(self) -> HeldMotors:
        """Motors that friction holds at rest otherwise than by its law: elongations leave more there than else."""
        tension = self.rows.tension + self.rows.residual / self.rows.compliance
        return HeldMotors(self.unknowns.rest_error > 0, tension)


def fit_cables(problem: ClockProblem, offset: float, cables: CableEquation, pulley_sigma: float = 0.0) -> ClockSolution:
    """The offset around the frames' middle from the cables alone, the skew at zero; from a start, s.

    cables: the equation of the problem's signals, with no lag yet; pulley_sigma: as in `ModelAssumptions`. Raises
    ClockUndetermined where the fit leaves the neighbourhood of the start."""
    unknowns = initial_unknowns(problem, offset, cables)
    assumptions = ModelAssumptions(cables.law, pulley_sigma=pulley_sigma)
    return solve_clock(problem, unknowns, assumptions, cables, skew_fixed=True)


def initial_unknowns(problem: ClockProblem, offset: float, cables: CableEquation) -> ClockUnknowns:
    """Where a fit begins: an offset, s, the arm as described, and the cables' parameters of a linear fit."""
    frames = problem.frames
    return ClockUnknowns(
        offset=offset,
        skew=0.0,
        delay=0.0,
        geometry_errors=np.zeros(frames.winding_by_geometry.shape[2]),
        fv=np.nan_to_num(problem.fv),
        cable_parameters=cables.initial_parameters(frames, offset),
        arm_parameters=np.zeros(0),
        cable_error=np.full(problem.fv.shape, INITIAL_CABLE_ERROR_M),
        rest_error=np.zeros(problem.fv.shape),
        noise_scale=1.0,
        torque_errors=np.zeros(0),
        torque_misfit=np.inf,
    )


def solve_clock(
    problem: ClockProblem,
    unknowns: ClockUnknowns,
    assumptions: ModelAssumptions,
    cables: CableEquation,
    arm: ArmRows | None = None,
    max_steps: int = MAX_STEPS,
    skew_fixed: bool = False,
) -> ClockSolution:
    """Gauss-Newton steps from an estimate on; the rows' weights and the cables' lag follow the estimate.

    arm: rows of the arm's equation, None for the cables alone. Raises ClockUndetermined where the offset moves away from
    the estimate by more than MAX_OFFSET_CHANGE_S."""
    frames, first_offset = problem.frames, unknowns.offset
    frame_weight = np.ones(len(frames.time))
    rows, lag_updates, equations = cables.rows(frames, unknowns), 0, None
    for step in range(max_steps):
        error = unknowns.cable_errors(rows.at_rest)
        whitening = frames.whitening(error, unknowns.noise_scale) * frame_weight[:, None, None]
        offset_before = unknowns.offset
        step_rows = StepRows(frames, rows, whitening, arm)
        gauss_newton = gauss_newton_step(step_rows, unknowns, assumptions, problem.fv, skew_fixed)
        equations = gauss_newton.equations
        unknowns, rows = _downhill(gauss_newton, step_rows, cables)
        if step:
            white = np.einsum("fij,fj->fi", whitening, rows.residual)
            frame_weight = _frame_weight(np.sqrt(np.mean(white**2, axis=1)) / frame_weight)
        unknowns = _with_error_sizes(unknowns, frames, rows, assumptions.motors_stick)
        tau = cables.lag(unknowns.cable_parameters)
        if lag_updates < MAX_LAG_UPDATES and step and np.max(np.abs(tau - cables.tau)) > LAG_TOLERANCE_S:
            cables, lag_updates = cables.with_lag(tau), lag_updates + 1
            rows = cables.rows(frames, unknowns)
        elif step > 1 and abs(unknowns.offset - offset_before) < OFFSET_TOLERANCE_S:
            break
    change = unknowns.offset - first_offset
    if not abs(change) < MAX_OFFSET_CHANGE_S:
        raise ClockUndetermined(
            "sync",
            f"cables and arm would have the clock {change:+.1f} s from where both show the same motion",
            "look at the elongations and forces of this recording, or give both a light",
        )
    assert equations is not None
    return ClockSolution(unknowns, equations, cables, rows)


def _with_error_sizes(
    unknowns: ClockUnknowns, frames: FrameGeometry, rows: CableRows, motors_stick: bool
) -> ClockUnknowns:
    """The unknowns with the errors of cables and angles. Where motors stick these are of the frames in which all turn, if they are
    enough, beside what more a cable errs by in those in which its motor is at rest."""
    if not motors_stick:
        cable_error, noise_scale = frames.error_sizes(rows.residual, unknowns.cable_error, unknowns.noise_scale)
        return replace(unknowns, cable_error=cable_error, noise_scale=noise_scale)
    turning = ~np.asarray(rows.at_rest.any(axis=1))
    if turning.sum() < MIN_OF_A_CLASS:
        turning[:] = True
    cable_error, noise_scale = frames.part(turning).error_sizes(
        rows.residual[turning], unknowns.cable_error, unknowns.noise_scale
    )
    rest_error = error_at_rest(rows.residual, rows.at_rest)
    return replace(unknowns, cable_error=cable_error, noise_scale=noise_scale, rest_error=rest_error)


def _downhill(step: Step, before: StepRows, cables: CableEquation) -> tuple[ClockUnknowns, CableRows]:
    """The unknowns after the largest of the halved shares of a step that does not lead uphill, and their rows.

    Far from the solution powers of the tension and the damping of the cables bend the equation, and a whole step may lead
    anywhere."""
    cost_before = step.cost(step.taken(0.0), before.cables.residual)
    share = 1.0
    while True:
        unknowns = step.taken(share)
        rows = cables.rows(before.frames, unknowns)
        if share < MIN_STEP or step.cost(unknowns, rows.residual) <= MAX_RISE * cost_before:
            return unknowns, rows
        share /= 2


def _frame_weight(size: Array) -> Array:
    """Weight of each frame by the size (F,) of its whitened residual: 1 but for outliers."""
    relative = size / max(np.median(size), 1e-9)
    return np.minimum(1.0, OUTLIER_SIGMA / np.maximum(relative, 1e-9))
