"""A clock that was set while a log was written is told from rows that are missing, late or unsteady."""

import numpy as np
import pytest

from synchronisation.clock_steps import clock_steps

ROW_S, COUNT = 0.002, 2 * np.pi / 2048
TIME = ROW_S * np.arange(10000, dtype=np.float64)
LATER = np.arange(10000) >= 6000
THETA = np.stack([30 * np.sin(0.9 * TIME), 20 * np.sin(1.3 * TIME + 1)], axis=1)
COUNTED = COUNT * np.round(THETA / COUNT)


@pytest.mark.parametrize("step", [0.0015, 0.005, 2.0])
def test_a_step_is_found_where_the_clock_was_set(step: float) -> None:
    found = clock_steps(TIME + np.where(LATER, step, 0.0), COUNTED)
    assert np.flatnonzero(found).tolist() == [6000]
    assert found[6000] == pytest.approx(step, abs=1e-9)


@pytest.mark.parametrize("missing", [1, 3, 1000])
def test_missing_rows_are_no_step(missing: int) -> None:
    kept = np.delete(np.arange(10000), slice(6000, 6000 + missing))
    assert not clock_steps(TIME[kept], COUNTED[kept]).any()


def test_stamps_that_are_late_or_unsteady_are_no_step() -> None:
    rng = np.random.default_rng(0)
    late = TIME + np.where(rng.random(10000) < 0.02, 0.0015, 0.0)
    assert not clock_steps(late, COUNTED).any()
    unsteady = np.sort(TIME + rng.normal(0, 3e-4, 10000)).astype(np.float64)
    assert not clock_steps(unsteady, COUNTED).any()


def test_motors_at_rest_tell_nothing() -> None:
    assert not clock_steps(TIME + np.where(LATER, 0.005, 0.0), 0 * THETA).any()
