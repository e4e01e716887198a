"""A force that never changes tells nothing of its cable, and accuses nobody; a cable may leave a share of what it stretches by."""

from dataclasses import replace

import numpy as np
import pytest

from identification.dataset.dataset import DataSet
from identification.dataset.frames import frame_angles
from identification.dataset.series import Series
from state_estimation.motors import motors_in
from synchronisation.check.check import MAX_UNEXPLAINED_M, MAX_UNEXPLAINED_SHARE, check_elongations
from synchronisation.check.observation import UNTOLD_M, observe
from tests.identification.test_estimates import recording


@pytest.fixture(scope="module")
def data() -> DataSet:
    return recording(2000, 0.02)


def with_column(data: DataSet, name: str, values: np.ndarray) -> DataSet:
    return replace(data, state=Series(data.state.time, {**data.state.columns, name: values}))


def test_nothing_is_named_of_a_cable_whose_force_never_changes(data: DataSet) -> None:
    constant = with_column(data, "f3", np.full(len(data.state), 40.0))
    arm, frames = data.arm, frame_angles(data)
    told, untold = (observe(arm, frames, motors_in(d.state)) for d in (data, constant))
    np.testing.assert_array_equal(told.law.untold, [False] * 4)
    np.testing.assert_array_equal(untold.law.untold, [False, False, True, False])
    assert not untold.law.forces.friction[2].any()
    added = untold.vision - told.vision
    np.testing.assert_allclose(added, np.diag([0, 0, UNTOLD_M**2, 0]) + 0 * added, atol=1e-9)
    assert check_elongations(arm, data.state, frames).faults == ()
    assert check_elongations(arm, constant.state, frames).faults == ()


def test_a_cable_may_leave_a_share_of_what_it_stretches_by(data: DataSet) -> None:
    """What a soft cable lags by is more than the whole error of a stiff one."""
    frames = frame_angles(data)
    rng = np.random.default_rng(3)
    slow = np.interp(data.state.time, data.state.time[::750], rng.standard_normal(len(data.state.time[::750])))
    winding = slow * 6e-4 / data.arm.drum[1]
    loose = with_column(data, "theta2", data.state.columns["theta2"] + winding)
    (fault,) = check_elongations(data.arm, loose.state, frames).faults
    assert fault["fault"] == "unexplained_elongation"
    assert fault["where"] == "cable 2"
    stretched = check_elongations(data.arm, loose.state, frames).cables[1].elongation_rms
    assert fault["size"] > max(MAX_UNEXPLAINED_M, MAX_UNEXPLAINED_SHARE * stretched)
