"""Splines through samples. Many signals are sampled at the same times: what only times decide is computed once for each grid."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline
from scipy.linalg import get_lapack_funcs

Array = NDArray[np.float64]

_KEPT_GRIDS = 4
_factored, _solved = get_lapack_funcs(("gbtrf", "gbtrs"), dtype=np.float64)


def interpolating_spline(time: Array, values: Array, degree: int) -> BSpline:
    """The spline through samples (T, ...) at times (T,), to the last bit that of scipy's `make_interp_spline`."""
    samples = np.asarray_chkfinite(values, dtype=float)
    knots, factors, pivots = _grid(np.asarray(time, dtype=float).tobytes(), degree)
    coefficients, _ = _solved(factors, degree, degree, samples.reshape(len(samples), -1), pivots)
    return BSpline.construct_fast(knots, np.ascontiguousarray(coefficients).reshape(samples.shape), degree)


@lru_cache(maxsize=_KEPT_GRIDS)
def _grid(time: bytes, degree: int) -> tuple[Array, Array, NDArray[np.intc]]:
    """Knots, and the factors with their pivots of what gives samples by coefficients, in LAPACK's band."""
    at = np.frombuffer(time)
    knots = make_interp_spline(at, np.zeros(len(at)), k=degree).t
    samples = BSpline.design_matrix(at, knots, degree).tocoo()
    band = np.zeros((3 * degree + 1, len(at)), order="F")
    band[2 * degree + samples.row - samples.col, samples.col] = samples.data
    factors, pivots, _ = _factored(band, degree, degree, overwrite_ab=True)
    return knots, factors, pivots
