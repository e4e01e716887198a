"""Named columns over time."""

import numpy as np

from identification.dataset.series import interpolated


def test_columns_are_straight_between_their_rows_and_held_beyond() -> None:
    columns = np.array([[0.0, 4.0], [2.0, 0.0]])
    expected = [[0.0, 4.0], [0.5, 3.0], [2.0, 0.0], [2.0, 0.0]]
    np.testing.assert_allclose(interpolated(np.array([0.0, 1.25, 2.0, 9.0]), np.array([1.0, 2.0]), columns), expected)
