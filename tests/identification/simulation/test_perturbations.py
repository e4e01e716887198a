"""Simulations that are run with what is uncertain: numbers of the laws take those of the recording along."""

import numpy as np
import pytest

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from identification.model_file import Model, ModelParameter, machine_of
from identification.simulation.perturbations import perturbed_runs
from identification.simulation.recording_parameters import RecordingParameters
from identification.simulation.windows import windows_of
from mechanism.arm import arm_of
from mechanism.description import read_neck
from tests.paths import NECK_FILE

NECK = read_neck(NECK_FILE)
STIFFNESS_SIGMA = 50.0
"""N/m, of the first cable's; all else of the laws is exact"""


def recording() -> DataSet:
    """An arm at rest, whose state is exact."""
    rows, joints, motors = 20, 3, 4
    columns: dict[str, np.ndarray] = {}
    for stem, count in (("alpha", joints), ("theta", motors)):
        for suffix in ("", "_d", "_dd"):
            columns |= numbered_columns(stem, np.zeros((rows, count)), suffix)
    empty = Series(np.zeros(0), {})
    state = Series(0.01 * np.arange(rows, dtype=float), columns)
    return DataSet(neck=NECK, neck_yaml="", state=state, fasquelle=empty, angles=empty, log=empty)


def model() -> Model:
    values = [("k", 8000.0, "N/m"), ("ca", 80.0, "N s/m")]
    parameters = tuple(
        ModelParameter(
            name=name, index=j, value=value, unit=unit, sigma=None, relative_sigma_percent=None, identified=True
        )
        for name, value, unit in values
        for j in (1, 2, 3, 4)
    )
    covariance = np.zeros((8, 8))
    covariance[0, 0] = STIFFNESS_SIGMA**2
    return Model(
        laws=("linear_cable",), parameters=parameters, covariance=tuple(tuple(row) for row in covariance.tolist())
    )


def test_a_doubt_about_a_law_moves_pre_elongation_and_delay_with_it() -> None:
    """Were the first cable stiffer by 50 N/m, its x0 would come out 50 um smaller, and the forces 0.1 ms later."""
    by_law = {(p.name, p.index): np.zeros(5) for p in model().parameters}
    by_law["k", 1] = np.array([-1e-6, 0.0, 0.0, 0.0, 2e-6])
    own = np.diag([0.0, 3e-5, 0.0, 0.0, 2e-4]) ** 2
    fitted = RecordingParameters(
        x0=np.full(4, 1e-3), delay=5e-3, covariance=own, f=np.zeros((20, 4)), memory_start={}, by_law=by_law
    )
    runs = perturbed_runs(
        windows_of(recording(), 0.1), model(), machine_of(model(), arm_of(NECK)), fitted, of_acceleration=False
    )
    delay = runs.delay - 5e-3
    x0 = runs.machine.arm.x0[:, 0] - (arm_of(NECK).x0 + 1e-3)
    stiffness = runs.machine.values["k"][:, 0, 0] - 8000.0
    assert delay[0] == stiffness[0] == 0
    assert np.sum(stiffness**2) == pytest.approx(STIFFNESS_SIGMA**2)
    assert np.sum(stiffness * delay) == pytest.approx(STIFFNESS_SIGMA**2 * 2e-6)
    assert np.sum(stiffness * x0[:, 0]) == pytest.approx(-(STIFFNESS_SIGMA**2) * 1e-6)
    assert np.sum(x0[:, 0] * delay) == pytest.approx(-5e-5 * 1e-4)
    assert np.sum(delay**2) == pytest.approx(1e-4**2 + 2e-4**2)
    assert np.sum(x0[:, 1] ** 2) == pytest.approx(3e-5**2)
