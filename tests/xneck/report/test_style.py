"""Curves are thinned without losing a peak."""

import numpy as np

from xneck.report.style import decimated


def test_decimation_keeps_every_peak() -> None:
    x = np.linspace(0, 1, 100_000)
    y = np.sin(40 * x)
    y[31_415] = 7.0
    thin_x, thin_y = decimated(x, y, points=1000)
    assert len(thin_x) <= 1002
    assert thin_y.max() == 7.0
    assert np.all(np.diff(thin_x) > 0)
    assert (thin_x[0], thin_x[-1]) == (0.0, 1.0)
