"""Fine alignment: offset and skew from the cables' equation and the arm's, solved together with all their nuisances.

Motor viscosity couples the two equations. Several sets of assumptions about what is not known are fitted: the first is reported,
and the spread of those that explain the recording as well enters its standard deviations.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from synchronisation.clocks.arm_equation import ArmRows, arm_equation_rows
from synchronisation.clocks.cable_equation import FORCE_SCALE_N, CableEquation, CableTerms
from synchronisation.clocks.frame_geometry import FrameGeometry
from synchronisation.clocks.gauss_newton_fit import ClockProblem, ClockSolution, initial_unknowns, solve_clock
from synchronisation.clocks.gauss_newton_step import SKEW_SCALE, ModelAssumptions
from synchronisation.clocks.signals import LogSignals
from synchronisation.clocks.unknowns import ClockUnknowns

Array = NDArray[np.float64]

REPORTED = ModelAssumptions()
"""assumptions whose estimate is reported"""
ALTERNATIVES = (
    ModelAssumptions(CableTerms(creep=(1.0, 6.0))),
    ModelAssumptions(CableTerms(powers=4)),
    ModelAssumptions(CableTerms(powers=2, creep=())),
    ModelAssumptions(joint_width=0.15),
    ModelAssumptions(drawing_scale=5.0),
)
"""assumptions whose spread enters the reported standard deviations"""
ALTERNATIVE_STEPS = 2
"""Gauss-Newton steps of each alternative, from the reported estimate on"""
MAX_MISFIT_RATIO = 1.15
"""an alternative counts if its misfit is at most so many times the reported one's (docs/thresholds.md)"""
MAX_LOSSY_MISFIT = 0.8
"""an arm is lossy where that leaves at most this share of what a sound arm leaves (docs/thresholds.md)"""
MAX_DRIVING_FV = 0.06
"""N s/rad: a viscosity further below zero is none; sigma holds how far the arm's equation moved the clock (docs/thresholds.md)"""
LINEAR_OFFSET_S = 2e-4
"""s: a larger change of the offset makes the rows of the arm's equation anew: viscous motors move it by milliseconds
(docs/thresholds.md)"""
MAX_LINEARISATIONS = 3
OFFSET_BIAS_SIGMA_S = 8e-6
"""s: standard deviation of the offset's bias by filters and by what no nuisance describes (docs/thresholds.md)"""
DELAY_BIAS_SIGMA_S = 1e-5
"""s: standard deviation of the delay's bias (docs/thresholds.md)"""


@dataclass(frozen=True)
class FineAlignment:
    """The reported fit with its standard deviations, which hold the spread of equally good alternatives and the bias."""

    fit: ClockSolution
    offset_sigma: float
    """s"""
    skew_sigma: float
    """ratio"""
    delay: float
    """s, by which forces act later than the log says"""
    delay_sigma: float
    """s"""
    frames: FrameGeometry
    """the frames that were fitted"""

    @property
    def offset(self) -> float:
        """s, at the frames' middle."""
        return self.fit.unknowns.offset


def align_finely(
    arm: Arm, signals: LogSignals, frames: FrameGeometry, offset: float, fv: Array, skew_scale: float = 1.0
) -> FineAlignment:
    """Offset (at the frames' middle) and skew, from a start within some 20 ms. fv: (M,), N s/rad, NaN where not known.

    skew_scale: as in `ModelAssumptions`. Raises ClockUndetermined where the fit leaves the neighbourhood of the start."""
    problem = ClockProblem(signals, frames, fv)
    cables = CableEquation(signals, REPORTED.law)
    assumptions = replace(REPORTED, skew_scale=skew_scale)
    from_cables = solve_clock(problem, initial_unknowns(problem, offset, cables), assumptions, cables)
    problem = replace(problem, frames=frames.with_slopes_beside_noise(arm, from_cables.residual))
    reported, rows = _sound_or_lossy(arm, problem, from_cables, assumptions)
    fits = [reported, *_alternatives(problem, reported, rows, skew_scale)]
    spread = [
        float(np.std([getattr(fit.unknowns, name) for fit in fits], ddof=1)) if len(fits) > 1 else 0.0
        for name in ("offset", "skew", "delay")
    ]
    statistical = np.sqrt(np.diag(reported.equations.covariance(3))) * [1.0, SKEW_SCALE, 1.0]
    # the offset's bias may differ between the two ends of a recording, which biases the skew
    half_duration = float(np.ptp(frames.time)) / 2
    bias = [OFFSET_BIAS_SIGMA_S, OFFSET_BIAS_SIGMA_S / half_duration, DELAY_BIAS_SIGMA_S]
    if reported.unknowns.fv.min() < -MAX_DRIVING_FV:
        # no motor drives so: what bent the arm's equation moved the clock along
        bias[0] = float(np.hypot(bias[0], reported.unknowns.offset - from_cables.unknowns.offset))
    offset_sigma, skew_sigma, delay_sigma = np.hypot(np.hypot(statistical, spread), bias)
    return FineAlignment(
        fit=reported,
        offset_sigma=float(offset_sigma),
        skew_sigma=float(skew_sigma),
        delay=reported.unknowns.delay,
        delay_sigma=float(delay_sigma),
        frames=frames,
    )


def _sound_or_lossy(
    arm: Arm, problem: ClockProblem, from_cables: ClockSolution, assumptions: ModelAssumptions
) -> tuple[ClockSolution, ArmRows]:
    """The fit to both equations and the rows of the arm's: of a lossy arm only where a sound one leaves much unexplained.

    Gains and losses share much with the offset, so that a sound arm's clock would be several times as uncertain with them."""
    sound, rows = _with_arm(arm, problem, from_cables, assumptions, lossy=False)
    known = np.concatenate([np.ones(len(problem.fv), dtype=bool), ~rows.of_lossy])
    parameters = np.zeros(len(known))
    parameters[known] = sound.unknowns.arm_parameters
    start = replace(sound.unknowns, arm_parameters=parameters)
    lossy = solve_clock(problem, start, assumptions, sound.cables, rows, max_steps=ALTERNATIVE_STEPS)
    if clock_misfit(lossy.unknowns) > MAX_LOSSY_MISFIT * clock_misfit(sound.unknowns):
        return sound, rows.of_sound_arm()
    return _with_arm(arm, problem, lossy, assumptions, lossy=True)


def _with_arm(
    arm: Arm, problem: ClockProblem, start: ClockSolution, assumptions: ModelAssumptions, lossy: bool
) -> tuple[ClockSolution, ArmRows]:
    """The fit to both equations from a start, and the rows of the arm's with all nuisances.

    Rows are linear in the offset: made anew where that has moved far."""
    fit, linearisations = start, 0
    while True:
        rows = _arm_rows_at(arm, problem, fit)
        fit = solve_clock(problem, fit.unknowns, assumptions, fit.cables, rows if lossy else rows.of_sound_arm())
        linearisations += 1
        if linearisations == MAX_LINEARISATIONS or abs(fit.unknowns.offset - rows.offset) < LINEAR_OFFSET_S:
            return fit, rows


def clock_misfit(unknowns: ClockUnknowns) -> float:
    """What cables, angles and arm leave unexplained, m times N m: the measure by which fits of one recording are compared.

    Angles count along: what a wrong clock leaves of the cables, turns of the joints explain for the most part."""
    torque_error = np.exp(np.mean(np.log(unknowns.torque_error)))
    return float(unknowns.cable_error * unknowns.noise_scale * torque_error)


def _alternatives(
    problem: ClockProblem, reported: ClockSolution, rows: ArmRows, skew_scale: float
) -> list[ClockSolution]:
    """Fits of the ALTERNATIVES that explain the recording about as well as the reported one."""
    fits, max_misfit = [], MAX_MISFIT_RATIO * clock_misfit(reported.unknowns)
    for assumptions in ALTERNATIVES:
        law = assumptions.law
        parameters = _translated(reported.unknowns.cable_parameters, REPORTED.law, law)
        cables = reported.cables
        if law != REPORTED.law:
            cables = CableEquation(problem.signals, law, cables.tau)
        same_width = assumptions.joint_width == REPORTED.joint_width
        fit = solve_clock(
            problem,
            replace(reported.unknowns, cable_parameters=parameters),
            replace(assumptions, skew_scale=skew_scale),
            cables,
            rows if same_width else rows.with_joint_width(assumptions.joint_width),
            max_steps=ALTERNATIVE_STEPS,
        )
        if clock_misfit(fit.unknowns) < max_misfit:
            fits.append(fit)
    return fits


def _translated(parameters: Array, old: CableTerms, new: CableTerms) -> Array:
    """Cables' parameters (M, K) of one law as a start for another: of the same name, else zero."""
    out = np.zeros((len(parameters), len(new.names)))
    for k, name in enumerate(new.names):
        if name in old.names:
            out[:, k] = parameters[:, old.names.index(name)]
    return out


def _arm_rows_at(arm: Arm, problem: ClockProblem, from_cables: ClockSolution) -> ArmRows:
    """Rows of the arm's equation at an estimate from the cables alone."""
    frames, unknowns = problem.frames, from_cables.unknowns
    at = frames.time + unknowns.offset + unknowns.skew * (frames.time - frames.middle)
    fs = FORCE_SCALE_N * unknowns.cable_parameters[:, REPORTED.law.names.index("h")]
    return arm_equation_rows(
        arm,
        problem.signals,
        at,
        frames,
        frames.turns(from_cables.residual),
        from_cables.cables.expected_winding(unknowns),
        REPORTED.joint_width,
        unknowns.offset,
        fs,
    )
