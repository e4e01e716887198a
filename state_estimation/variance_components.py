"""What vision and cables together tell of the cables' errors and of the joints' priors.

Either depends on the other: residuals of a solution tell the errors (restricted maximum likelihood, see wander.py), angles as the
cables tell them show priors what lies below vision's noise.
"""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from state_estimation.cable_equations import CableEquations, Cables, cable_angles, cable_rows
from state_estimation.elongation_error import Wander
from state_estimation.fusion import FusedSplines, solve
from state_estimation.motion_prior import DOUBT, Mixture, calmer, fit_mixture
from state_estimation.spline import knots_over

Array = NDArray[np.float64]

ROUNDS, PRIOR_ROUND = 6, 3
"""that the cables' errors are told in, and the one of them that tells the priors again"""
ENOUGH_S = 60.0
"""s from the middle that tell both well enough"""
PROBES = 4
"""of white noise, for what a solution leaves of the cables' errors"""


def told_by_both(
    vision: FusedSplines,
    seen: FrameAngles,
    cables: Cables,
    wander: list[Wander],
    used: NDArray[np.bool_],
    priors: list[Mixture],
) -> tuple[list[Wander], list[Mixture]]:
    """The cables' errors and the joints' priors, as vision and cables tell them together in the middle of the recording."""
    middle = (cables.time[0] + cables.time[-1]) / 2
    seen = seen.within(middle - ENOUGH_S / 2, middle + ENOUGH_S / 2)
    rows = (cables.time >= seen.time[0]) & (cables.time <= seen.time[-1])
    cables = cables.part(rows)
    knots, near = knots_over(seen.time[0], seen.time[-1], vision.knots.step), vision.alpha(cables.time)
    m = cables.arm.M
    probes = np.random.default_rng(0).normal(size=(m, len(cables.time), PROBES))
    for k in range(ROUNDS):
        stretches = list(cable_rows(cables, knots, near, vision.mean, wander))
        fit = solve(knots, vision.mean, seen, priors, stretches)
        near = fit.alpha(cables.time)
        noise = np.split(-probes, np.cumsum([one.X.shape[1] for one in stretches])[:-1], axis=1)
        answer = _answer(fit, stretches, noise)
        left = np.concatenate([one.left(fit.c, fit.beta, one.y) for one in stretches], axis=1)
        kept = np.concatenate([one.left(*answer, n) for one, n in zip(stretches, noise, strict=True)], axis=1)
        wander = [w.retold(left[j], probes[j], kept[j]) if used[j] else w for j, w in enumerate(wander)]
        if k == PRIOR_ROUND and sum(used) >= cables.arm.N:
            # the cables show what lies below vision's noise: the spectrum's far end
            told, spread = cable_angles(cables, near, fit.beta.reshape(m, -1), wander)
            priors = [
                calmer(
                    fit_mixture(cables.time, told[:, i] - vision.mean[i], spread[:, i], vision.knots.step, DOUBT),
                    vision.priors[i],
                )
                for i in range(cables.arm.N)
            ]
    return wander, priors


def _answer(fit: FusedSplines, stretches: list[CableEquations], noise: list[Array]) -> tuple[Array, Array]:
    """c (n, Q) and beta (M P, Q) were the rows to measure noise, (M, K, Q) of each stretch."""
    of_c, of_beta = np.zeros((len(fit.c), PROBES)), np.zeros((len(fit.beta), PROBES))
    for rows, part in zip(stretches, noise, strict=True):
        more_c, more_beta = rows.right(part)
        of_c[rows.columns] += more_c
        of_beta += more_beta
    return fit.both(of_c, of_beta)
