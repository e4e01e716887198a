"""What a log's rounding of the forces leaves of the equations is drawn as much as it is, and nothing where it rounds to nothing."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.input_variance import force_steps, residuals_of_friction, residuals_of_rounding
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from identification.signals import Signals, signals_of
from tests.identification.test_estimates import recording


@pytest.fixture(scope="module")
def data() -> DataSet:
    return recording(2000)


def rms(residuals: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(residuals**2, axis=1))


@pytest.mark.parametrize("step", [0.2, 2.0])
@pytest.mark.parametrize("rough_N", [0.0, 3.0])
def test_as_much_is_drawn_as_rounding_leaves(data: DataSet, step: float, rough_N: float) -> None:
    """Of forces that change at every row, and of smooth ones that stay the same for several."""
    f = data.state.matrix("f") + rough_N * np.random.default_rng(1).standard_normal(data.state.matrix("f").shape)

    def signals(forces: np.ndarray) -> Signals:
        return signals_of(
            replace(data, state=replace(data.state, columns={**data.state.columns, **numbered_columns("f", forces)}))
        )

    exact, rounded = signals(f), signals(step * np.round(f / step))
    left = rms(residuals_of_friction(exact, exact.f - rounded.f))
    rng = np.random.default_rng(0)
    drawn = rms(
        np.concatenate(
            [residuals_of_rounding(rounded, step * np.round(f / step), np.full(4, step), rng) for _ in range(4)], axis=1
        )
    )
    # some hundred independent rows, and a course that is smooth over a step is not quite evenly rounded
    np.testing.assert_allclose(drawn, left, rtol=0.35)
    assert not residuals_of_rounding(rounded, f, np.zeros(4), rng).any()


def test_steps_of_forces_are_told_where_they_count(data: DataSet) -> None:
    def logged(step: float) -> np.ndarray:
        f = data.log.matrix("f")
        f = f + np.random.default_rng(2).standard_normal(f.shape)
        forces = step * np.round(f / step) if step else f
        return force_steps(
            replace(data, log=Series(data.log.time, {**data.log.columns, **numbered_columns("f", forces)}))
        )

    np.testing.assert_allclose(logged(0.5), 0.5, rtol=1e-3)
    np.testing.assert_array_equal(logged(0.001), np.zeros(4))
    np.testing.assert_array_equal(logged(0.0), np.zeros(4))
    without = replace(data, log=Series(data.log.time, {}))
    np.testing.assert_array_equal(force_steps(without), np.zeros(4))
