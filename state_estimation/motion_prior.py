"""A prior of joint motion in two parts, smooth motion and rough motion, fitted to samples.

Where dry friction changes sign it kicks an arm that moves smoothly otherwise. The spectrum of such motion is steep up to some
frequency and flat beyond, which no single pole gives: a steep one denies the kicks, a flat one expects them everywhere. So a signal
is the sum of two processes (see spline.py), each with its own coefficients, side by side at each knot: the smooth part, then the
rough one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, minimize

from state_estimation.banded import banded_cholesky
from state_estimation.smoother import BANDWIDTH, normal_equations
from state_estimation.spline import SUPPORT, Knots, SplinePrior, knots_over

Array = NDArray[np.float64]

PARTS = 2
"""coefficients of a signal at each knot"""
ROUGH = 1
"""place of the rough part's coefficient among them"""
SMOOTH_ORDERS = (4, 8)
"""orders that are tried for the smooth part (docs/thresholds.md)"""
ROUGH_ORDER = 3
"""an acceleration that is a random walk: torques that dry friction switches reach the arm through elastic cables
(docs/thresholds.md)"""
ROUGH_CORNER = 6.0
"""rad/s; slower motion belongs to the smooth part (docs/thresholds.md)"""
MIN_LOG_CORNER = np.log(3e-5)
"""order log(corner step): below it the prior's precision matrix is lost in rounding"""
ROUGHNESS_ALLOWANCE = 8.0
"""-2 log likelihood that a larger rough part may cost (docs/thresholds.md)"""
MAX_SAMPLES = 1500
"""samples from the middle of a signal that the prior is fitted to (docs/thresholds.md)"""
_MIN_LOG_SIZE, _MAX_LOG_SIZE = -12.5, 3.5
"""limits of the logarithm of the rough part's standard deviation over the signal's"""
_BISECTIONS = 7
MAX_EVALUATIONS = 150
"""of the likelihood, at most (docs/thresholds.md)"""
SCREENING_EVALUATIONS, MAX_SCREENED_COST = 60, 600.0
"""evaluations after which an order is given up whose best -2 log likelihood is worse by so much than another order's
(docs/thresholds.md)"""


@dataclass(frozen=True)
class TwoPartPrior:
    """The smooth and the rough part's priors."""

    smooth: SplinePrior
    rough: SplinePrior

    def bands(self, knots: Knots) -> tuple[Array, Array]:
        """Precision of both parts' coefficients, lower bands of up to BANDWIDTH + 1 rows, (..., count)."""
        return self.smooth_band(knots), self.rough.band(knots)

    def smooth_band(self, knots: Knots) -> Array:
        """Precision of the smooth part's coefficients."""
        band = self.smooth.band(knots)
        # keeps a steep prior's precision positive definite in spite of rounding; far smaller than any coefficient's own
        band[0] += self.smooth.initial_sigma**-2
        return band

    def unresolved_variance(self, step: float) -> Array:
        """Variances of the value and its two derivatives at frequencies that knots `step` apart cannot carry, (3,).

        They carry pi / step, and beyond the corner the rough part's density is step innovation_sigma^2 / (w step)^(2 order).
        """
        order, d = self.rough.order, np.arange(3)
        size = self.rough.innovation_sigma**2 / step ** (2.0 * d)
        return size * np.pi ** (2.0 * (d - order)) / (2 * (order - d) - 1)

    def log_determinant(self, knots: Knots) -> float:
        """Logarithm of the determinant of both parts' precision."""
        return self.smooth.log_determinant(knots) + self.rough.log_determinant(knots)


def joint_band(measured: list[Array], priors: list[tuple[Array, Array]], reach: int = BANDWIDTH) -> Array:
    """Lower band of the normal equations of all signals, their parts side by side at each knot.

    reach: knots over which anything couples coefficients, BANDWIDTH at least. measured: of each signal the band
    (BANDWIDTH + 1, count) of its samples, which measure the sum of its parts and couple SUPPORT knots. priors: of each signal the
    bands of its parts; none yet where it is empty.
    """
    n = PARTS * len(measured)
    count = measured[0].shape[1]
    band = np.zeros(((reach + 1) * n, n * count))
    for i, samples in enumerate(measured):
        for r in range(PARTS):
            for s in range(PARTS):
                # row of part r at knot k + lag, column of part s at knot k
                first = 0 if r >= s else 1
                rows = slice(first * n + r - s, SUPPORT * n + r - s, n)
                band[rows, PARTS * i + s :: n] += samples[first:SUPPORT]
    add_priors(band, priors)
    return band


def add_priors(band: Array, priors: list[tuple[Array, Array]]) -> None:
    """Adds the bands of the parts of each signal to a joint band."""
    n = PARTS * len(priors)
    for i, parts in enumerate(priors):
        for r, part in enumerate(parts):
            band[: len(part) * n : n, PARTS * i + r :: n] += part


def fit_two_part_prior(time: Array, values: Array, variance: Array, step: float, allowance: float) -> TwoPartPrior:
    """The prior for knots `step` apart that makes samples of mean zero most likely, with as large a rough part as they allow.

    The likelihood is that of knots as far apart as the samples, where these are further: closer ones tell no more.

    allowance: what the rough part may cost in -2 log likelihood. Where kicks lie below the samples' noise, the likeliest prior
    denies them, and its variance of accelerations is wrong by two sigma and more.
    """
    part = slice(max(0, len(time) // 2 - MAX_SAMPLES // 2), len(time) // 2 + MAX_SAMPLES // 2)
    t, y, r = time[part], values[part], variance[part]
    fitted_step = max(step, float(np.median(np.diff(t))))
    knots = knots_over(t[0], t[-1], fitted_step)
    measured, right = normal_equations(knots, t, y, r)
    measured, right = joint_band([measured], []), np.repeat(right, PARTS)
    constant = float(np.sum(np.log(r)) + np.sum(y**2 / r))
    initial_sigma = 10 * float(np.std(y)) + 10 * float(np.sqrt(np.median(r)))

    def prior(order: int, v: Array, step: float) -> TwoPartPrior:
        """v: logarithms of the smooth part's corner in rad/s, and of both parts' standard deviations over `initial_sigma`."""
        corner = float(np.exp(v[0]))
        smooth_innovation = float(np.exp(v[1])) * initial_sigma * (corner * step) ** (order - 0.5)
        rough_size = float(np.exp(v[2])) * initial_sigma
        rough_innovation = rough_size * (ROUGH_CORNER * step) ** (ROUGH_ORDER - 0.5)
        return TwoPartPrior(
            SplinePrior(order, corner, smooth_innovation, initial_sigma),
            SplinePrior(ROUGH_ORDER, ROUGH_CORNER, rough_innovation, 3 * rough_size),
        )

    def cost(order: int, v: Array) -> float:
        if not (-3 < v[0] < np.log(0.8 / fitted_step) and -12 < v[1] < 12 and _MIN_LOG_SIZE < v[2] < _MAX_LOG_SIZE):
            return 1e12
        if (v[0] + np.log(step)) * order < MIN_LOG_CORNER:
            return 1e12
        p = prior(order, v, fitted_step)
        # no wider than this prior needs
        band = measured[: PARTS * (max(order, SUPPORT - 1) + 1)].copy()
        add_priors(band, [(p.smooth_band(knots), rough_of_unit / p.rough.initial_sigma**2)])
        try:
            cholesky = banded_cholesky(band)
        except np.linalg.LinAlgError:
            return 1e12
        explained = float(np.sum(cholesky.solve_first_half(right) ** 2))
        return cholesky.log_determinant - p.log_determinant(knots) + constant - explained

    any_rough = prior(SMOOTH_ORDERS[0], np.zeros(3), fitted_step).rough
    rough_of_unit = any_rough.scaled(1 / any_rough.initial_sigma).band(knots)
    best: tuple[float, int, Array] | None = None
    for order in SMOOTH_ORDERS:
        start = np.array([np.log(6.0 * np.sqrt(order)), 0.0, -6.0])
        hopeless = best[0] + MAX_SCREENED_COST if best else np.inf
        minimum = _minimum(partial(cost, order), start, hopeless)
        if best is None or minimum.fun < best[0]:
            best = float(minimum.fun), order, minimum.x
    assert best is not None
    least, order, v = best
    low, high = max(float(v[2]), _MIN_LOG_SIZE + 0.5), _MAX_LOG_SIZE - 0.5
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        if cost(order, np.array([v[0], v[1], middle])) < least + allowance:
            low = middle
        else:
            high = middle
    return prior(order, np.array([v[0], v[1], low]), step)


def _minimum(cost: Callable[[Array], float], start: Array, hopeless: float) -> OptimizeResult:
    """The likeliest parameters from a start; given up after SCREENING_EVALUATIONS where all have cost more than `hopeless`."""
    evaluations = 0

    def counted(v: Array) -> float:
        nonlocal evaluations
        evaluations += 1
        return cost(v)

    def give_up(intermediate_result: OptimizeResult) -> None:
        if evaluations >= SCREENING_EVALUATIONS and intermediate_result.fun > hopeless:
            raise StopIteration

    simplex = start + np.array([[0, 0, 0], [0.7, 0, 0], [0, 1.5, 0], [0, 0, 2.0]])
    options = {"xatol": 0.05, "fatol": 0.1, "maxfev": MAX_EVALUATIONS, "initial_simplex": simplex}
    return minimize(counted, start, method="Nelder-Mead", callback=give_up, options=options)
