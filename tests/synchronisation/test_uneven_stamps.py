"""Whether rows of a log were sampled as they are stamped is told by the motors' angles."""

import numpy as np
import pytest
from numpy.typing import NDArray

from synchronisation.uneven_stamps import even_times_of

Array = NDArray[np.float64]

STEP_S, ROWS = 0.002, 6000


def turning(time: Array) -> Array:
    """Angles of two motors, rad: 8 and 5 turns a second at the most, to a count of 1e-4 rad."""
    motors = [30 * np.sin(1.7 * time) + 5 * np.sin(4.1 * time), 25 * np.cos(1.1 * time) + 3 * np.sin(5.3 * time + 1)]
    return np.array(np.round(np.stack(motors, axis=1), 4), dtype=float)


def sampled() -> Array:
    """Times of an even loop, s, that begin beside a millisecond."""
    return np.array(5.00037 + STEP_S * np.arange(ROWS), dtype=float)


@pytest.mark.parametrize("unsteady_s", [0.0, 0.0005])
def test_whole_milliseconds_are_those_of_an_even_loop(unsteady_s: float) -> None:
    time = sampled() if unsteady_s else 5.0004 + 1.0007 * (sampled() - 5)
    late = np.random.default_rng(3).uniform(-unsteady_s, unsteady_s, ROWS)
    stamps = np.floor(1000 * (time + late)) / 1000
    found = even_times_of(stamps, turning(time))
    assert found is not None
    # a rounded stamp is early by half a millisecond in the mean
    off = found.time - time + 0.0005
    assert np.sqrt(np.mean(off**2)) < 0.00002
    assert found.spread == pytest.approx(np.std(stamps - time), rel=0.1)
    assert found.step == pytest.approx(np.mean(np.diff(time)), rel=1e-4)


def test_stamps_of_a_loop_that_is_unsteady_stay() -> None:
    time = np.cumsum(np.random.default_rng(4).uniform(0.0012, 0.0028, ROWS))
    assert even_times_of(time, turning(time)) is None


def test_a_log_at_even_times_and_one_at_rest_stay() -> None:
    time = sampled()
    assert even_times_of(time, turning(time)) is None
    assert even_times_of(np.floor(1000 * time + np.arange(ROWS) % 2) / 1000, np.ones((ROWS, 2))) is None


def test_rows_that_are_missing_are_missing_in_the_even_times() -> None:
    time = sampled()
    there = np.ones(ROWS, dtype=bool)
    there[2000:2003] = there[4000] = False
    late = np.random.default_rng(5).uniform(-0.0004, 0.0004, ROWS)
    found = even_times_of(np.floor(1000 * (time + late)[there]) / 1000, turning(time)[there])
    assert found is not None
    np.testing.assert_allclose(np.diff(found.time), np.diff(time[there]), atol=0.0001)
