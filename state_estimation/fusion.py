"""Angles of all joints from vision, priors and cables: one banded least squares, with the law's factors as its border."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from state_estimation.banded import Factor, factor
from state_estimation.cable_equations import CableEquations, add_rows
from state_estimation.elongation_error import SPREAD_M
from state_estimation.motion_prior import PARTS, Mixture, side_by_side
from state_estimation.smoother import normal_equations
from state_estimation.spline import Knots

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FusedSplines:
    """A solved system: coefficients c (joints side by side at each knot), and the border's V = H^-1 G and Schur complement."""

    knots: Knots
    mean: Array
    priors: list[Mixture]
    c: Array
    beta: Array
    factor: Factor
    V: Array
    mixed: Array
    schur: Array

    def alpha(self, time: Array, derivative: int = 0) -> Array:
        """(T, N)"""
        n = len(self.mean)
        own = self.mean if derivative == 0 else 0.0
        return self.knots.design(time, derivative) @ self.c.reshape(-1, n, PARTS).sum(axis=2) + own

    def both(self, of_c: Array, of_beta: Array) -> tuple[Array, Array]:
        """Coefficients c (n, ...) and beta (p, ...) of right sides of these shapes."""
        direct = self.factor.solve(of_c)
        beta = np.asarray(np.linalg.solve(self.schur, of_beta + self.mixed.T @ direct), dtype=float)
        return direct + self.V @ beta, beta

    def response(self, right: Array) -> Array:
        """How coefficients answer to a change (n, k) of the right side."""
        return self.both(right, np.zeros((len(self.schur), right.shape[1])))[0]


def solve(
    knots: Knots, mean: Array, seen: FrameAngles, priors: list[Mixture], cables: Iterable[CableEquations] | None = None
) -> FusedSplines:
    """Vision and priors, with the cables' rows where given."""
    measured, right = [], np.zeros((knots.count, len(mean), PARTS))
    for i in range(len(mean)):
        known = ~np.isnan(seen.alpha[:, i])
        own, b = normal_equations(knots, seen.time[known], seen.alpha[known, i] - mean[i], seen.sigma[known, i] ** 2)
        measured.append(own)
        right[:, i] = b[:, None]
    band, right = side_by_side(measured, [prior.bands(knots) for prior in priors]), right.ravel()
    if cables is None:
        found = factor(band)
        none = np.zeros((len(right), 0))
        return FusedSplines(knots, mean, priors, found.solve(right), np.zeros(0), found, none, none, np.zeros((0, 0)))
    told = add_rows(band, cables)
    found = factor(band)
    V = found.solve(told.mixed)
    schur = told.own + np.eye(len(told.own)) / SPREAD_M**2 - told.mixed.T @ V
    fit = FusedSplines(knots, mean, priors, right, np.zeros(len(schur)), found, V, told.mixed, schur)
    c, beta = fit.both(right + told.of_c, told.of_beta)
    return replace(fit, c=c, beta=beta)


def misfit(fit: FusedSplines, seen: FrameAngles) -> float:
    """Mean square of vision's residuals over what noise of its sigma alone would leave: what the fit does to one such noise."""
    known = np.isfinite(seen.alpha)
    sigma = np.where(known, seen.sigma, 1.0)
    left = np.where(known, seen.alpha - fit.alpha(seen.time), 0.0) / sigma
    # signs have the mean square of one exactly
    signs = np.where(known, np.random.default_rng(0).choice([-1.0, 1.0], known.shape), 0.0)
    design = fit.knots.design(seen.time)
    answer = fit.response(np.repeat((design.T @ (signs / sigma)).ravel(), PARTS)[:, None])
    followed = np.where(known, design @ answer.reshape(-1, len(fit.mean), PARTS).sum(axis=2) / sigma, 0.0)
    return float(np.sum(left**2) / np.sum((signs - followed) ** 2))
