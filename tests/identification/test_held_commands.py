"""Means of commands that a drive holds, against steps on a fine grid."""

import numpy as np
import pytest

from identification.held_commands import mean_held_force

FORCE = np.array([[3.0], [-1.0], [4.0], [1.0], [-5.0]])


@pytest.mark.parametrize("late", [0.0, 0.3, 1.7, -0.4, 9.0, -9.0])
def test_means_are_those_of_steps_that_begin_late(late: float) -> None:
    """Half a row each, from two rows before the first to two after the last, against 10 000 points a row."""
    edges = np.arange(-2.0, 7.5, 0.5) - late
    fine = (np.arange(5_000) + 0.5) / 10_000
    for begin, mean in zip(edges[:-1], mean_held_force(FORCE, edges)[:, 0], strict=True):
        rows = np.clip(np.floor(begin + fine).astype(int), 0, len(FORCE) - 1)
        assert mean == pytest.approx(FORCE[rows, 0].mean(), abs=1e-3)


def test_what_is_held_over_whole_rows_is_itself() -> None:
    np.testing.assert_allclose(mean_held_force(FORCE, np.arange(6.0)), FORCE)
