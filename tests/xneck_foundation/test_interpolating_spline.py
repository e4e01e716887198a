"""Splines through samples are scipy's, to the last bit."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from xneck_foundation.interpolating_spline import interpolating_spline


@pytest.mark.parametrize("degree", [3, 5])
@pytest.mark.parametrize("shape", [(), (1,), (4, 3)])
def test_it_is_the_one_of_scipy(degree: int, shape: tuple[int, ...]) -> None:
    """On even and uneven times, on times that came before, and where values are views or whole numbers."""
    rng = np.random.default_rng(degree)
    even, uneven = 0.3 + 0.01 * np.arange(200.0), np.cumsum(rng.uniform(0.01, 0.05, 150))
    times: list[np.ndarray] = [even, uneven, even[: degree + 1], even]
    for time in times:
        values = rng.normal(size=(*shape, len(time)))
        for samples in (np.moveaxis(values, -1, 0), np.round(10 * np.moveaxis(values, -1, 0)).astype(int)):
            found, known = interpolating_spline(time, samples, degree), make_interp_spline(time, samples, k=degree)
            assert found.k == known.k
            np.testing.assert_array_equal(found.t, known.t)
            np.testing.assert_array_equal(found.c, known.c)
            np.testing.assert_array_equal(found(time[1:] - 0.004, 1), known(time[1:] - 0.004, 1))


def test_what_is_no_number_and_times_that_do_not_rise_are_refused() -> None:
    time = np.arange(10.0)
    with pytest.raises(ValueError, match="infs or NaNs"):
        interpolating_spline(time, np.where(time == 4, np.nan, time), 3)
    with pytest.raises(ValueError, match="increasing"):
        interpolating_spline(time[::-1], time, 3)
    with pytest.raises(ValueError):  # noqa: PT011 (scipy's own words)
        interpolating_spline(time[:3], time[:3], 3)
