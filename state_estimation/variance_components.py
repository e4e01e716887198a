"""Variance components: the spectra of the cables' errors and the joints' motion priors, from vision and cables together.

Either depends on the other. Residuals of a solution give the errors' spectra (restricted maximum likelihood, see
elongation_error_spectrum); angles by the cables alone show the priors what lies below vision's noise.
"""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from state_estimation.cable_equations import CableEquations, CableMeasurements, cable_angles, cable_rows
from state_estimation.elongation_error_spectrum import ErrorSpectrum
from state_estimation.fusion import SplineSolution, solve_splines
from state_estimation.motion_prior import ROUGHNESS_ALLOWANCE, TwoPartPrior, fit_two_part_prior, less_rough
from state_estimation.spline import knots_over

Array = NDArray[np.float64]

ITERATIONS, PRIOR_ITERATION = 6, 3
"""re-estimations of the cables' spectra, and after which of them, from zero, the priors are fitted again (docs/thresholds.md)"""
MAX_SPAN_S = 60.0
"""s from the middle of a recording that both are estimated from (docs/thresholds.md)"""
PROBE_COUNT = 4
"""signals of white noise that show what a solution leaves of the cables' errors"""


def estimate_variance_components(
    vision: SplineSolution,
    frames: FrameAngles,
    cables: CableMeasurements,
    spectra: list[ErrorSpectrum],
    used: NDArray[np.bool_],
) -> tuple[list[ErrorSpectrum], list[TwoPartPrior]]:
    """Spectra of the cables' errors and priors of the joints' motion.

    vision: the solution without cables. spectra: where to start from; those of cables that are not `used` (M,) stay as they are.
    """
    middle = (cables.time[0] + cables.time[-1]) / 2
    frames = frames.within(middle - MAX_SPAN_S / 2, middle + MAX_SPAN_S / 2)
    rows = (cables.time >= frames.time[0]) & (cables.time <= frames.time[-1])
    cables = cables.part(rows)
    knots = knots_over(frames.time[0], frames.time[-1], vision.knots.step)
    alpha, priors = vision.alpha(cables.time), vision.priors
    m = cables.arm.M
    probes = np.random.default_rng(0).normal(size=(m, len(cables.time), PROBE_COUNT))
    for k in range(ITERATIONS):
        equations = list(cable_rows(cables, knots, alpha, vision.mean, spectra))
        solution = solve_splines(knots, vision.mean, frames, priors, equations)
        alpha = solution.alpha(cables.time)
        noise = np.split(-probes, np.cumsum([rows.X.shape[1] for rows in equations])[:-1], axis=1)
        response = _response_to_noise(solution, equations, noise)
        residuals = np.concatenate([rows.residuals(solution.c, solution.beta, rows.y) for rows in equations], axis=1)
        probe_residuals = np.concatenate(
            [rows.residuals(*response, part) for rows, part in zip(equations, noise, strict=True)], axis=1
        )
        spectra = [
            s.reestimated(residuals[j], probes[j], probe_residuals[j]) if used[j] else s for j, s in enumerate(spectra)
        ]
        if k == PRIOR_ITERATION and sum(used) >= cables.arm.N:
            by_cables, variance = cable_angles(cables, alpha, solution.beta.reshape(m, -1), spectra)
            priors = [
                less_rough(
                    fit_two_part_prior(
                        cables.time,
                        by_cables[:, i] - vision.mean[i],
                        variance[:, i],
                        vision.knots.step,
                        ROUGHNESS_ALLOWANCE,
                    ),
                    vision.priors[i],
                )
                for i in range(cables.arm.N)
            ]
    return spectra, priors


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
