"""Angles of all joints from vision, motion priors and cables: one banded least squares, bordered by the cables' nuisances."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from state_estimation.banded import BandedCholesky, banded_cholesky
from state_estimation.cable_equations import CableEquations, add_rows, rows_reach
from state_estimation.elongation_error_spectrum import REGRESSOR_SIGMA_M
from state_estimation.motion_prior import PARTS, TwoPartPrior, joint_band
from state_estimation.smoother import BANDWIDTH, normal_equations
from state_estimation.spline import Knots

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SplineSolution:
    """Solved splines of all joints, with what is needed to solve again for other right sides."""

    knots: Knots
    mean: Array
    """mean angle of each joint, (N,), rad, which the splines are about"""
    priors: list[TwoPartPrior]
    c: Array
    """coefficients, parts of joints side by side at each knot, (n,), n = count N PARTS"""
    beta: Array
    """factors of the cables' regressors, (M P,); empty without cables"""
    H: BandedCholesky
    """factor of the normal matrix of c"""
    W: Array
    """half of the solution of the normal matrix's border, by H: H^-1 of A^T X is the second half's, (n, M P)"""
    schur: Array
    """Schur complement of H: the inverse covariance of beta, (M P, M P)"""
    unresolved: Array
    """variances of each joint's angle and two derivatives by motion that is faster than the knots carry, (3, N), SI units"""

    def alpha(self, time: Array, derivative: int = 0) -> Array:
        """Angles or their derivatives at times (T,), s; shape (T, N)."""
        n = len(self.mean)
        mean = self.mean if derivative == 0 else 0.0
        return self.knots.design(time, derivative) @ self.c.reshape(-1, n, PARTS).sum(axis=2) + mean

    def solve(self, of_c: Array, of_beta: Array) -> tuple[Array, Array]:
        """Coefficients c (n, ...) and beta (M P, ...) for right sides of these shapes."""
        half = self.H.solve_first_half(of_c)
        beta = np.asarray(np.linalg.solve(self.schur, of_beta + self.W.T @ half), dtype=float)
        return self.H.solve_second_half(half + self.W @ beta), beta

    def response(self, of_c: Array) -> Array:
        """Change of the coefficients by a change (n, k) of their right side."""
        return self.solve(of_c, np.zeros((len(self.schur), of_c.shape[1])))[0]


@dataclass(frozen=True)
class VisionEquations:
    """Normal equations of the frames, for splines about a mean angle of each joint."""

    knots: Knots
    mean: Array
    """(N,), rad"""
    measured: list[Array]
    """of each joint, the lower band of its angles' coefficients"""
    right: Array
    """of the coefficients of all parts, (n,)"""


def vision_equations(knots: Knots, mean: Array, frames: FrameAngles) -> VisionEquations:
    """Of frames, for splines about mean angles (N,), rad."""
    measured, right = [], np.zeros((knots.count, len(mean), PARTS))
    for i in range(len(mean)):
        known = ~np.isnan(frames.alpha[:, i])
        band, of_samples = normal_equations(
            knots, frames.time[known], frames.alpha[known, i] - mean[i], frames.sigma[known, i] ** 2
        )
        measured.append(band)
        right[:, i] = of_samples[:, None]
    return VisionEquations(knots, mean, measured, right.ravel())


def solve_splines(
    vision: VisionEquations, priors: list[TwoPartPrior], cables: Iterable[CableEquations] | None = None
) -> SplineSolution:
    """Splines by vision and priors, with the cables' equations where given."""
    knots, mean, right = vision.knots, vision.mean, vision.right
    reach = BANDWIDTH if cables is None else rows_reach(knots.step)
    band = joint_band(vision.measured, [_bands(prior, knots) for prior in priors], reach)
    unresolved = np.stack([prior.unresolved_variance(knots.step) for prior in priors], axis=-1)
    if cables is None:
        H, no_border = banded_cholesky(band), np.zeros((len(right), 0))
        return SplineSolution(
            knots=knots,
            mean=mean,
            priors=priors,
            c=H.solve(right),
            beta=np.zeros(0),
            H=H,
            W=no_border,
            schur=np.zeros((0, 0)),
            unresolved=unresolved,
        )
    products = add_rows(band, cables)
    H = banded_cholesky(band)
    W = H.solve_first_half(products.A_X)
    schur = products.X_X + np.eye(len(products.X_X)) / REGRESSOR_SIGMA_M**2 - W.T @ W
    system = SplineSolution(
        knots=knots,
        mean=mean,
        priors=priors,
        c=right,
        beta=np.zeros(len(schur)),
        H=H,
        W=W,
        schur=schur,
        unresolved=unresolved,
    )
    c, beta = system.solve(right + products.A_y, products.X_y)
    return replace(system, c=c, beta=beta)


def _bands(prior: TwoPartPrior, knots: Knots) -> tuple[Array, Array]:
    """The prior's bands, the steep smooth part's held positive definite beside a rough part of any size.

    What is added is the rounding error of a factorisation. A coefficient's standard deviation by it alone is some five times the
    signal's at the steepest prior that is fitted.
    """
    smooth, rough = prior.bands(knots)
    smooth[0] += 16 * np.finfo(float).eps * np.max(smooth[0])
    return smooth, rough


def vision_misfit(solution: SplineSolution, frames: FrameAngles) -> float:
    """Mean square of vision's residuals over the mean square that noise of the stated sigma would leave in this solution."""
    known = np.isfinite(frames.alpha)
    sigma = np.where(known, frames.sigma, 1.0)
    residuals = np.where(known, frames.alpha - solution.alpha(frames.time), 0.0) / sigma
    # random signs stand for noise: their mean square is one exactly
    signs = np.where(known, np.random.default_rng(0).choice([-1.0, 1.0], known.shape), 0.0)
    design = solution.knots.design(frames.time)
    response = solution.response(np.repeat((design.T @ (signs / sigma)).ravel(), PARTS)[:, None])
    fitted = np.where(known, design @ response.reshape(-1, len(solution.mean), PARTS).sum(axis=2) / sigma, 0.0)
    return float(np.sum(residuals**2) / np.sum((signs - fitted) ** 2))
