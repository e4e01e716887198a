"""A prior of two parts: motion that is smooth, and what is rough in it, as the samples tell both.

Dry friction that turns over kicks an arm whose motion is smooth else. Its spectrum is then steep up to some frequency and flat
beyond, which no single pole gives: a steep one denies the kicks, a flat one believes them everywhere. So a signal is the sum of two
processes (see spline.py), each with coefficients of its own, side by side at each knot: first the smooth part, then the rough one.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from state_estimation.banded import factor
from state_estimation.smoother import WIDTH, normal_equations, padded
from state_estimation.spline import SUPPORT, Knots, Prior, knots_over

Array = NDArray[np.float64]

PARTS = 2
"""coefficients of a signal at each knot"""
ORDERS = (4, 8)
"""tried for the smooth part"""
ROUGH_ORDER = 3
"""an acceleration that wanders: torques that dry friction switches reach the arm through elastic cables"""
ROUGH_CORNER = 6.0
"""rad/s; what is slower is the smooth part's"""
STIFFEST = np.log(3e-5)
"""(corner step)^order below it would lose the prior's precision in rounding"""
DOUBT = 8.0
"""what the prior's rough part may cost of -2 log likelihood, z of 2.8: kicks are few and come in bursts, so that a stationary
likelihood is surer than it may be"""
ENOUGH = 3000
"""samples from the middle that tell the prior well enough"""
_LEAST, _MOST = -12.5, 3.5
"""logarithm of the rough part's size"""
_HALVINGS = 7
PATIENCE = 150
"""evaluations, after which -2 log likelihood falls by less than 2 where the rough part is nothing and its size may be any"""


@dataclass(frozen=True)
class Mixture:
    """Both parts' spectra."""

    smooth: Prior
    rough: Prior

    def bands(self, knots: Knots) -> tuple[Array, Array]:
        """Precision of both parts' coefficients, lower bands (WIDTH + 1, count)."""
        smooth, rough = padded(self.smooth.band(knots)), padded(self.rough.band(knots))
        # far below what it is everywhere, and above rounding in a steep prior's precision
        smooth[0] += self.smooth.spread**-2
        return smooth, rough

    def beyond(self, step: float) -> float:
        """Variance of the second derivative at frequencies that knots `step` apart do not carry.

        Beyond the corner a part's density is step drive^2 / (w step)^(2 order); integrated from pi / step on, times w^4 / pi.
        """
        return sum(
            prior.drive**2 / step**4 * np.pi ** (4 - 2 * prior.order) / (2 * prior.order - 5)
            for prior in (self.smooth, self.rough)
        )

    def log_determinant(self, knots: Knots) -> float:
        """Of the precision of both."""
        return self.smooth.log_determinant(knots) + self.rough.log_determinant(knots)


def calmer(one: Mixture, other: Mixture) -> Mixture:
    """One, as rough as the calmer of both: each is rough as its samples just allow, and both must hold."""
    return Mixture(one.smooth, min(one.rough, other.rough, key=lambda prior: prior.drive))


def side_by_side(measured: list[Array], priors: list[tuple[Array, Array]]) -> Array:
    """Lower band of all signals' parts side by side at each knot: measured sums of the parts, and the parts' own priors.

    Bands of each signal alone (WIDTH + 1, count); samples couple SUPPORT knots.
    """
    n = PARTS * len(measured)
    count = measured[0].shape[1]
    out = np.zeros(((WIDTH + 1) * n, n * count))
    for i, (own, parts) in enumerate(zip(measured, priors, strict=True)):
        for r in range(PARTS):
            out[::n, PARTS * i + r :: n] += parts[r]
            for s in range(PARTS):
                # row of part r at knot k + lag, column of part s at knot k
                for lag in range(0 if r >= s else 1, SUPPORT):
                    out[lag * n + r - s, PARTS * i + s :: n] += own[lag]
    return out


def fit_mixture(time: Array, values: Array, variance: Array, step: float, doubt: float) -> Mixture:
    """The prior for knots `step` apart that makes samples of mean zero most likely, and as rough as they allow.

    doubt: what the rough part may cost in -2 log likelihood. Where kicks lie below the samples' noise, the likeliest prior
    denies them, and what it claims to know of accelerations is wrong by two sigma and more.
    """
    part = slice(max(0, len(time) // 2 - ENOUGH // 2), len(time) // 2 + ENOUGH // 2)
    t, y, r = time[part], values[part], variance[part]
    knots = knots_over(t[0], t[-1], step)
    design, b = normal_equations(knots, t, y, r)
    both = np.repeat(b, PARTS)
    fixed = float(np.sum(np.log(r)) + np.sum(y**2 / r))
    spread = 10 * float(np.std(y)) + 10 * float(np.sqrt(np.median(r)))

    def prior(order: int, v: Array) -> Mixture:
        """v: logarithms of the smooth part's corner in rad/s, and of both standard deviations over `spread`."""
        corner = float(np.exp(v[0]))
        smooth = Prior(order, corner, float(np.exp(v[1])) * spread * (corner * step) ** (order - 0.5), spread)
        size = float(np.exp(v[2])) * spread
        drive = size * (ROUGH_CORNER * step) ** (ROUGH_ORDER - 0.5)
        return Mixture(smooth, Prior(ROUGH_ORDER, ROUGH_CORNER, drive, 3 * size))

    def cost(order: int, v: Array) -> float:
        if not (-3 < v[0] < np.log(0.8 / step) and -12 < v[1] < 12 and _LEAST < v[2] < _MOST):
            return 1e12
        if (v[0] + np.log(step)) * order < STIFFEST:
            return 1e12
        p = prior(order, v)
        try:
            found = factor(side_by_side([design], [p.bands(knots)]))
        except np.linalg.LinAlgError:
            return 1e12
        return found.log_determinant - p.log_determinant(knots) + fixed - float(both @ found.solve(both))

    best: tuple[float, int, Array] | None = None
    for order in ORDERS:
        start = np.array([np.log(6.0 * np.sqrt(order)), 0.0, -6.0])
        simplex = start + np.array([[0, 0, 0], [0.7, 0, 0], [0, 1.5, 0], [0, 0, 2.0]])
        found = minimize(
            lambda v, order=order: cost(order, v), start, method="Nelder-Mead",
            options={"xatol": 0.05, "fatol": 0.1, "maxfev": PATIENCE, "initial_simplex": simplex},
        )  # fmt: skip
        if best is None or found.fun < best[0]:
            best = float(found.fun), order, found.x
    assert best is not None
    least, order, v = best
    low, high = max(float(v[2]), _LEAST + 0.5), _MOST - 0.5
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if cost(order, np.array([v[0], v[1], middle])) < least + doubt:
            low = middle
        else:
            high = middle
    return prior(order, np.array([v[0], v[1], low]))
