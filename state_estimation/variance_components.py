"""Variance components: the spectra of the cables' errors and the joints' motion priors, from vision and cables together.

Either depends on the other. Residuals of a solution give the errors' spectra, and its innovations the size of the rough motion
(restricted maximum likelihood as a fixed point, see elongation_error_spectrum): cables show rough motion far below vision's noise.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from state_estimation.cable_equations import CableEquations, CableMeasurements, cable_rows
from state_estimation.elongation_error_spectrum import EDGES_HZ, MIN_RESIDUAL_SHARE, ErrorSpectrum
from state_estimation.elongation_law import ElongationLaw
from state_estimation.fusion import SplineSolution, solve_splines, vision_equations
from state_estimation.motion_prior import PARTS, ROUGH, ROUGH_ORDER, TwoPartPrior
from state_estimation.spline import Knots, knots_over

Array = NDArray[np.float64]

SLOW_ITERATIONS, ITERATIONS = 2, 3
"""re-estimations of the cables' spectra with vision's priors, and then of both (docs/thresholds.md)"""
FAST_HZ, FIRST_DENSITY, FIRST_ROUGHNESS = 4.0, 0.05, 2.0
"""from this frequency on the second half begins with so much of the cables' errors as the first half found, and rough motion with
so many times what vision shows: cables tell fast motion better than vision, and errors that are there show themselves
(docs/thresholds.md)"""
MAX_DENSITY = 16.0
"""times what vision bounds the cables' errors by, which no band exceeds (docs/thresholds.md)"""
MAX_SPAN_S = 60.0
"""s from the middle of a recording that both are estimated from (docs/thresholds.md)"""
PROBE_COUNT = 4
"""signals of white noise that show what a solution leaves of the cables' errors"""


@dataclass(frozen=True)
class VarianceComponents:
    """What vision and cables say together of their own errors and of the motion."""

    spectra: list[ErrorSpectrum]
    """of the cables' errors"""
    priors: list[TwoPartPrior]
    """of the joints' motion"""
    law: ElongationLaw
    """of the elongations, its friction and lags by vision and cables together"""
    alpha: Array
    """(K, N), rad, at the cables' times: those of vision alone beyond MAX_SPAN_S"""


def estimate_variance_components(
    vision: SplineSolution,
    frames: FrameAngles,
    cables: CableMeasurements,
    spectra: list[ErrorSpectrum],
    used: NDArray[np.bool_],
) -> VarianceComponents:
    """Spectra of the cables' errors and priors of the joints' motion, and the cables' law beside which they are these.

    vision: the solution without cables. spectra: where to start from; those of cables that are not `used` (M,) stay as they are.
    """
    everywhere, middle = vision.alpha(cables.time), (cables.time[0] + cables.time[-1]) / 2
    frames = frames.within(middle - MAX_SPAN_S / 2, middle + MAX_SPAN_S / 2)
    rows = (cables.time >= frames.time[0]) & (cables.time <= frames.time[-1])
    cables = cables.part(rows)
    knots = knots_over(frames.time[0], frames.time[-1], vision.knots.step)
    of_frames = vision_equations(knots, vision.mean, frames)
    alpha, priors = everywhere[rows], vision.priors
    m = cables.arm.M
    probes = np.random.default_rng(0).normal(size=(m, len(cables.time), PROBE_COUNT))
    most = [MAX_DENSITY * s.density for s in spectra]
    fast = np.where(np.array(EDGES_HZ) >= FAST_HZ, FIRST_DENSITY, 1.0)
    # fewer cables than joints do not tell rough motion from errors, and vision's own priors stay
    tells_motion = bool(np.sum(used) >= cables.arm.N)
    innovation_probes = np.random.default_rng(1).normal(size=(knots.count - ROUGH_ORDER, PROBE_COUNT))
    law = cables.law
    for k in range(SLOW_ITERATIONS + ITERATIONS):
        if k == SLOW_ITERATIONS and tells_motion:
            spectra = [replace(s, density=fast * s.density) if used[j] else s for j, s in enumerate(spectra)]
            priors = [replace(p, rough=p.rough.scaled(FIRST_ROUGHNESS)) for p in priors]
        equations = list(cable_rows(cables, knots, alpha, vision.mean, spectra))
        solution = solve_splines(of_frames, priors, equations)
        alpha = solution.alpha(cables.time)
        if k >= SLOW_ITERATIONS and tells_motion:
            priors = [_resized(p, knots, solution, i, innovation_probes) for i, p in enumerate(priors)]
        noise = np.split(-probes, np.cumsum([rows.X.shape[1] for rows in equations])[:-1], axis=1)
        response = _response_to_noise(solution, equations, noise)
        residuals = np.concatenate([rows.residuals(solution.c, solution.beta, rows.y) for rows in equations], axis=1)
        probe_residuals = np.concatenate(
            [rows.residuals(*response, part) for rows, part in zip(equations, noise, strict=True)], axis=1
        )
        spectra = [
            s.reestimated(residuals[j], probes[j], probe_residuals[j]).at_most(most[j]) if used[j] else s
            for j, s in enumerate(spectra)
        ]
        # of the first law: step after step it would drift to where it explains errors of the cables that no law has
        law = cables.law.corrected(cables.factors(solution.beta))
    everywhere[rows] = alpha
    return VarianceComponents(spectra, priors, law, everywhere)


def _resized(prior: TwoPartPrior, knots: Knots, solution: SplineSolution, joint: int, probes: Array) -> TwoPartPrior:
    """The prior of a joint with a rough part as large as the solution's innovations say, as ErrorSpectrum.reestimated does.

    probes: (innovations, Q)
    """
    of_c = np.zeros((knots.count, len(solution.mean), PARTS, probes.shape[1]))
    of_c[:, joint, ROUGH] = prior.rough.innovations_transposed(knots, probes)
    response = solution.response(of_c.reshape(len(solution.c), -1)).reshape(of_c.shape)[:, joint, ROUGH]
    # an innovation is a row that measures zero, and the solution leaves of its noise what it does not take up
    expected = len(probes) - float(np.mean(np.sum(probes * prior.rough.innovations(knots, response), axis=0)))
    if expected < MIN_RESIDUAL_SHARE * len(probes):
        return prior
    c = solution.c.reshape(knots.count, -1, PARTS)[:, joint, ROUGH]
    power = float(np.sum(prior.rough.innovations(knots, c) ** 2))
    return replace(prior, rough=prior.rough.scaled(float(np.sqrt(power / expected))))


def _response_to_noise(
    solution: SplineSolution, equations: list[CableEquations], noise: list[Array]
) -> tuple[Array, Array]:
    """c (n, Q) and beta (M P, Q) of the solution if the equations measured noise, (M, K, Q) each, and vision nothing."""
    of_c, of_beta = np.zeros((len(solution.c), PROBE_COUNT)), np.zeros((len(solution.beta), PROBE_COUNT))
    for rows, part in zip(equations, noise, strict=True):
        part_of_c, part_of_beta = rows.right_sides(part)
        of_c[rows.columns] += part_of_c
        of_beta += part_of_beta
    return solution.solve(of_c, of_beta)
