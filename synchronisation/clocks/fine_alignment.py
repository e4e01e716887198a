"""Fine alignment: offset and skew from the cables' equation and the arm's, solved together with all their nuisances.

Motor viscosity couples the two equations. Several sets of assumptions about what is not known are fitted: the first is reported,
and the spread of those that explain the recording as well enters its standard deviations.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.motor_rest import error_at_rest
from mechanism.arm import Arm
from synchronisation.clocks.arm_equation import ArmRows, arm_equation_rows
from synchronisation.clocks.cable_equation import FORCE_SCALE_N, CableEquation, CableTerms
from synchronisation.clocks.frame_geometry import FrameGeometry
from synchronisation.clocks.gauss_newton_fit import (
    MAX_STEPS,
    ClockProblem,
    ClockSolution,
    initial_unknowns,
    solve_clock,
)
from synchronisation.clocks.gauss_newton_step import SKEW_SCALE, ModelAssumptions
from synchronisation.clocks.signals import LogSignals
from synchronisation.clocks.unknowns import ClockUnknowns

Array = NDArray[np.float64]

REPORTED = ModelAssumptions()
"""assumptions whose estimate is reported"""
OTHER_LAWS = ({"creep": (1.0, 6.0)}, {"powers": 4}, {"powers": 2, "creep": ()})
"""terms of the cables that are otherwise in assumptions whose spread enters the reported standard deviations"""
OTHER_MEMORY = 0.5
"""widths of play operators over the usual ones in one more, where cables remember"""
OTHER_ASSUMPTIONS = ({"joint_width": 0.15}, {"drawing_scale": 5.0})
"""what else is otherwise in such assumptions"""
ALTERNATIVE_STEPS = 2
"""Gauss-Newton steps of each alternative, from the reported estimate on"""
MAX_MISFIT_RATIO = 1.15
"""an alternative counts if its misfit is at most so many times the reported one's (docs/thresholds.md)"""
MAX_LOSSY_MISFIT = 0.8
"""an arm is lossy where that leaves at most this share of what a sound arm leaves (docs/thresholds.md)"""
MAX_MEMORY_MISFIT = 0.8
"""cables or drives have a memory where that leaves at most this share of what those without leave (docs/thresholds.md)"""
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
    assumptions: ModelAssumptions
    """of the reported fit"""
    lossy: bool
    """whether the arm has gains and losses in that fit"""

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
    if error_at_rest(from_cables.residual, from_cables.rows.at_rest).any():
        assumptions = replace(assumptions, motors_stick=True)
        from_cables = solve_clock(problem, from_cables.unknowns, assumptions, from_cables.cables)
    problem = replace(
        problem, frames=frames.with_slopes_beside_noise(arm, from_cables.residual, from_cables.unknowns.cable_error)
    )
    explained = _with_or_without_memory(arm, problem, _sound_or_lossy(arm, problem, from_cables, assumptions))
    reported = explained.fit
    fits = [reported, *_alternatives(problem, explained)]
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
        assumptions=explained.assumptions,
        lossy=explained.lossy,
    )


def refitted_to(arm: Arm, signals: LogSignals, fine: FineAlignment, fv: Array) -> ClockUnknowns:
    """The unknowns of a fit to other signals of the log with all that `fine` assumes, and no alternative. fv: (M,), N s/rad.

    Raises ClockUndetermined where the fit leaves the neighbourhood of `fine`."""
    law, unknowns = fine.assumptions.law, fine.fit.unknowns
    problem = ClockProblem(signals, fine.frames, fv)
    cables = CableEquation(signals, law, fine.fit.cables.tau, _dry_friction(unknowns, law))
    start = replace(unknowns, arm_parameters=np.zeros(0), delay=0.0)
    fit = solve_clock(problem, start, fine.assumptions, cables)
    problem = replace(problem, frames=fine.frames.with_slopes_beside_noise(arm, fit.residual, fit.unknowns.cable_error))
    return _with_arm(arm, problem, fit, fine.assumptions, fine.lossy)[0].unknowns


@dataclass(frozen=True)
class _Explained:
    """A fit to both equations, and what it assumes."""

    fit: ClockSolution
    rows: ArmRows
    """of the arm's equation, with the nuisances that were fitted"""
    assumptions: ModelAssumptions
    tried: tuple[ClockSolution, ...] = ()
    """fits with other assumptions that were not taken"""
    lossy: bool = False
    """whether the arm has gains and losses"""


def _with_or_without_memory(arm: Arm, problem: ClockProblem, usual: _Explained) -> _Explained:
    """The fit, or where that leaves much less unexplained one in which cables and drives remember their way.

    What play or hysteresis does to a cable, friction of another form does nearly as well at another time; often only the arm shows
    the difference."""
    remembering = replace(usual.assumptions, law=replace(usual.assumptions.law, memory=1.0))
    trial = _refitted(problem, usual, remembering, usual.rows, MAX_STEPS)
    if clock_misfit(trial.unknowns) > MAX_MEMORY_MISFIT * clock_misfit(usual.fit.unknowns):
        return replace(usual, tried=(*usual.tried, trial))
    start = replace(trial, unknowns=replace(trial.unknowns, arm_parameters=np.zeros(0)))
    return _sound_or_lossy(arm, problem, start, remembering)


def _sound_or_lossy(
    arm: Arm, problem: ClockProblem, from_cables: ClockSolution, assumptions: ModelAssumptions
) -> _Explained:
    """The fit to both equations: of a lossy arm only where a sound one leaves much unexplained.

    Gains and losses share much with the offset, so that a sound arm's clock would be several times as uncertain with them."""
    sound, rows = _with_arm(arm, problem, from_cables, assumptions, lossy=False)
    known = np.concatenate([np.ones(len(problem.fv), dtype=bool), ~rows.of_lossy])
    parameters = np.zeros(len(known))
    parameters[known] = sound.unknowns.arm_parameters
    start = replace(sound.unknowns, arm_parameters=parameters)
    lossy = solve_clock(problem, start, assumptions, sound.cables, rows, max_steps=ALTERNATIVE_STEPS)
    if clock_misfit(lossy.unknowns) > MAX_LOSSY_MISFIT * clock_misfit(sound.unknowns):
        return _Explained(sound, rows.of_sound_arm(), assumptions, (lossy,))
    return _Explained(*_with_arm(arm, problem, lossy, assumptions, lossy=True), assumptions, lossy=True)


def _with_arm(
    arm: Arm, problem: ClockProblem, start: ClockSolution, assumptions: ModelAssumptions, lossy: bool
) -> tuple[ClockSolution, ArmRows]:
    """The fit to both equations from a start, and the rows of the arm's with all nuisances.

    Rows are linear in the offset: made anew where that has moved far."""
    fit, linearisations = start, 0
    while True:
        rows = _arm_rows_at(arm, problem, fit, assumptions)
        fit = solve_clock(problem, fit.unknowns, assumptions, fit.cables, rows if lossy else rows.of_sound_arm())
        linearisations += 1
        if linearisations == MAX_LINEARISATIONS or abs(fit.unknowns.offset - rows.offset) < LINEAR_OFFSET_S:
            return fit, rows


def clock_misfit(unknowns: ClockUnknowns) -> float:
    """What cables, angles and arm leave unexplained, m times N m: the measure by which fits of one recording are compared.

    Angles count along: what a wrong clock leaves of the cables, turns of the joints explain for the most part. That angles would
    be better than their sigma says is no merit: where cables err by much, nothing is left for the angles' noise."""
    cable_error = np.exp(np.mean(np.log(unknowns.cable_error)))
    return float(cable_error * max(unknowns.noise_scale, 1.0) * unknowns.torque_misfit)


def _alternatives(problem: ClockProblem, explained: _Explained) -> list[ClockSolution]:
    """Fits with other assumptions that explain the recording about as well as the reported one."""
    reported, rows = explained.assumptions, explained.rows
    laws = [replace(reported.law, **terms) for terms in OTHER_LAWS]
    if reported.law.memory > 0:
        laws.append(replace(reported.law, memory=OTHER_MEMORY))
    others = [replace(reported, law=law) for law in laws]
    fits = [_refitted(problem, explained, other, rows, ALTERNATIVE_STEPS) for other in others]
    if explained.fit.held.motors.any():
        # where friction holds motors the rest is not known as well as a sound arm's
        fits += explained.tried
    for other in (replace(reported, **changes) for changes in OTHER_ASSUMPTIONS):
        wider = rows if other.joint_width == reported.joint_width else rows.with_joint_width(other.joint_width)
        fits.append(_refitted(problem, explained, other, wider, ALTERNATIVE_STEPS))
    max_misfit = MAX_MISFIT_RATIO * clock_misfit(explained.fit.unknowns)
    return [fit for fit in fits if clock_misfit(fit.unknowns) < max_misfit]


def _refitted(
    problem: ClockProblem, explained: _Explained, other: ModelAssumptions, rows: ArmRows, steps: int
) -> ClockSolution:
    """From a fit on with other assumptions and with these rows of the arm's equation, at most so many steps."""
    fit, law = explained.fit, explained.assumptions.law
    fs = _dry_friction(fit.unknowns, law)
    cables = fit.cables if other.law == law else CableEquation(problem.signals, other.law, fit.cables.tau, fs)
    parameters = _translated(fit.unknowns.cable_parameters, law, other.law)
    return solve_clock(
        problem, replace(fit.unknowns, cable_parameters=parameters), other, cables, rows, max_steps=steps
    )


def _translated(parameters: Array, old: CableTerms, new: CableTerms) -> Array:
    """Cables' parameters (M, K) of one law as a start for another: of the same name, else zero."""
    out = np.zeros((len(parameters), len(new.names)))
    for k, name in enumerate(new.names):
        if name in old.names:
            out[:, k] = parameters[:, old.names.index(name)]
    return out


def _arm_rows_at(arm: Arm, problem: ClockProblem, from_cables: ClockSolution, assumptions: ModelAssumptions) -> ArmRows:
    """Rows of the arm's equation at an estimate from the cables alone."""
    frames, unknowns = problem.frames, from_cables.unknowns
    at = frames.time + unknowns.offset + unknowns.skew * (frames.time - frames.middle)
    return arm_equation_rows(
        arm,
        problem.signals,
        at,
        frames,
        frames.turns(from_cables.residual, unknowns.cable_error),
        from_cables.cables.expected_winding(unknowns),
        unknowns.cable_error,
        assumptions.joint_width,
        unknowns.offset,
        _dry_friction(unknowns, assumptions.law),
        from_cables.held,
    )


def _dry_friction(unknowns: ClockUnknowns, law: CableTerms) -> Array:
    """Of each motor, (M,), N, by the cables."""
    return FORCE_SCALE_N * unknowns.cable_parameters[:, law.names.index("h")]
