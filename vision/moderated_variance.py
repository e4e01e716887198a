"""How noisy each frame is, by what the arm's fit leaves of its own corners.

A codec spends more on some pictures than on others, so their noise differs by more than chance. Each frame has too few corners to
tell its noise by itself: its variance is drawn towards that of all frames, the less the more those differ (moderated variances,
Smyth 2004). Assumed is that frames' variances are spread as an inverse chi-square; a frame that stands out even so, as something
lies over a marker, is taken by itself.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root_scalar
from scipy.special import digamma, polygamma
from scipy.stats import chi2

Array = NDArray[np.float64]

RESIDUAL_QUANTILE = 0.99
"""quantile of the noise's chi-square above which a frame has the variance of its own residuals (docs/thresholds.md)"""
MAX_PRIOR_FREEDOM = 1e4
"""degrees of freedom of the prior from which on all frames have one variance"""


def moderated_variances(squares: Array, freedom: Array) -> Array:
    """Variance of each frame, (F,), from its sum of squares and their degrees of freedom, (F,); without any it is that of all."""
    told = (freedom >= 1) & (squares > 0)
    if np.count_nonzero(told) < 2:
        return np.where(told, squares / np.maximum(freedom, 1), 1.0)
    half = freedom[told] / 2
    level = np.log(squares[told] / freedom[told]) - digamma(half) + np.log(half)
    excess = float(np.var(level, ddof=1) - np.mean(polygamma(1, half)))
    prior = _prior_freedom(excess)
    of_all = np.exp(np.mean(level) + digamma(prior / 2) - np.log(prior / 2))
    drawn = (prior * of_all + np.where(told, squares, 0.0)) / (prior + np.where(told, freedom, 0.0))
    stands_out = told & (squares > drawn * chi2.ppf(RESIDUAL_QUANTILE, np.maximum(freedom, 1)))
    return np.where(stands_out, squares / np.maximum(freedom, 1), drawn)


def _prior_freedom(variance_of_log: float) -> float:
    """Degrees of freedom of an inverse chi-square whose logarithm has this variance."""
    if variance_of_log <= polygamma(1, MAX_PRIOR_FREEDOM / 2):
        return MAX_PRIOR_FREEDOM
    found = root_scalar(lambda d: polygamma(1, d / 2) - variance_of_log, bracket=(1e-3, MAX_PRIOR_FREEDOM))
    return float(found.root)
