"""Rows that were sampled are told from those in which a logger wrote one sample again, by made logs alone."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from identification.dataset.series import Series, numbered_columns
from identification.dataset.true_rows import rows_of_sample, sampled_rows
from synchronisation.clocks.log_gaps import repair_log

COUNT_RAD = 2 * np.pi / 2048


def moving_log(seconds: float = 20.0) -> Series:
    """Counted angles of four motors that go fast, turn over and rest for a second, and a force that a controller makes of them."""
    time = np.arange(0, seconds, 0.002)
    goes = gaussian_filter1d(((time < 5) | (time > 6)).astype(float), 50)
    own = 0.002 * np.cumsum(np.where(goes > 1e-3, goes, 0.0))
    path = np.stack([5 * np.sin(1.3 * own + j) + 2 * np.sin(3.1 * own) for j in range(4)], axis=-1)
    theta = COUNT_RAD * np.rint(path / COUNT_RAD)
    return Series(time, numbered_columns("theta", theta) | numbered_columns("f", np.round(40 + 3 * theta, 3)))


def held(log: Series, rows_of: np.ndarray) -> Series:
    """A log whose row i holds what was sampled in row rows_of[i]."""
    return Series(log.time, {name: column[rows_of] for name, column in log.columns.items()})


@pytest.mark.parametrize("rows", [2, 3, 5, 8])
def test_a_logger_that_asks_several_times_for_each_sample_is_as_slow_as_these(rows: int) -> None:
    """Where motors are slow too, so that no jump tells it; and a log of 100 samples a second has no gaps."""
    log = moving_log()
    at = np.arange(len(log))
    asked = held(log, at // rows * rows)
    sampled = sampled_rows(asked)
    assert sampled[::rows].all()
    assert np.mean(sampled) < 1 / rows + 1e-3
    repaired = repair_log(asked)
    assert repaired.gaps == ()
    assert any(f"{repaired.repeated_rows} of {len(log)} rows of the log repeat" in text for text in repaired.warnings())


def test_a_log_of_which_every_row_is_new_is_left_whole() -> None:
    log = moving_log()
    assert sampled_rows(log).all()
    equal = np.all([np.diff(column) == 0 for column in log.columns.values()], axis=0)
    assert equal.any()  # at rest, and where motors turn over
    assert rows_of_sample(equal) == (1, 0)
    assert repair_log(log).warnings() == ()


def test_single_rows_that_repeat_a_sample_in_motion_are_found() -> None:
    """Of those in motion all; where motors are slow two equal rows are usual."""
    log, rng = moving_log(), np.random.default_rng(4)
    at = np.arange(len(log))
    late = np.sort(rng.choice(at[10:], 400, replace=False))
    late = late[np.diff(late, prepend=0) > 3]
    at[late] -= 1
    found = ~sampled_rows(held(log, at))
    assert set(np.flatnonzero(found)) <= set(late)
    theta = log.matrix("theta") / COUNT_RAD
    fast = late[
        np.min(np.abs(np.stack([theta[late + k] - theta[late + k - 1] for k in (-1, 0, 1)])), axis=0).max(axis=1) > 4
    ]
    assert len(fast) > 100
    assert found[fast].mean() > 0.95
