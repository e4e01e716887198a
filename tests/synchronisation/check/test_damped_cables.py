"""Cables that follow their force late are healthy, whatever they lag by."""

from dataclasses import replace

import numpy as np
import pytest

from identification.dataset.dataset import DataSet
from identification.dataset.frames import frame_angles
from identification.dataset.series import Series
from state_estimation.motors import motors_in
from synchronisation.check.check import check_elongations
from synchronisation.check.observation import observe
from synchronisation.check.scoring import fit_law
from tests.identification.test_estimates import K, recording

MOST_LEFT_M = 1e-5
"""half of vision's noise through Z; of cables that were taken to follow at once 60 to 300 um were left"""


@pytest.fixture(scope="module")
def data() -> DataSet:
    return recording(2000, 0.02)


def damped(data: DataSet, ca: float) -> DataSet:
    """The same motion with dampers beside the cables, N s/m: motors pull by as much more as these take."""
    x = data.state.matrix("x")
    pull = ca * np.gradient(x, data.state.time, axis=0)
    forces = {f"f{j + 1}": data.state.columns[f"f{j + 1}"] + pull[:, j] for j in range(data.arm.M)}
    return replace(data, state=Series(data.state.time, {**data.state.columns, **forces}))


@pytest.mark.parametrize("ca", [0.0, 300.0, 800.0])
def test_what_a_damper_takes_is_explained(ca: float, data: DataSet) -> None:
    """Fasquelle's cables have up to 805 N s/m. What a lag leaves was taken for an angle's scale, where cables outnumber joints."""
    of_dampers = damped(data, ca)
    observation = observe(data.arm, frame_angles(data), motors_in(of_dampers.state))
    assert np.all(fit_law(observation).error < MOST_LEFT_M)
    assert check_elongations(data.arm, of_dampers.state, frame_angles(data)).faults == ()


def test_a_cable_lags_by_its_damper_over_its_stiffness(data: DataSet) -> None:
    """By the stiffness that the recording was made with; the state between frames leaves some per cent at a lag of .14 s."""
    at_once, *late = (
        observe(data.arm, frame_angles(data), motors_in(damped(data, ca).state)).law.forces.lag
        for ca in (0.0, 300.0, 800.0)
    )
    for ca, lag in zip((300.0, 800.0), late, strict=True):
        np.testing.assert_allclose(ca / (lag - at_once), K, rtol=0.05)
