"""Arrays are in SI units and the model's signs: what neck.yaml says of how a log is written is not applied to them again."""

import numpy as np
import pytest

from identification.dataset.dataset import DataSet
from mechanism.description import Neck, read_neck
from synchronisation.from_arrays import dataset_from_arrays
from tests.identification.test_estimates import recording
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

NECK = read_neck(NECK_FILE)
CONVERTED = NECK.with_(
    {"motors.theta_scale": np.radians(1.0), "motors.theta_sign": -1, "motors.f_scale": -2500.0, "alpha_zero": [0.02, -0.01, 0.05]}
)  # fmt: skip


@pytest.fixture(scope="module")
def data() -> DataSet:
    return recording(2001)


def again(neck: Neck, data: DataSet, theta_by: float = 1.0) -> DataSet:
    frames, log = data.angles, data.log
    theta, f = theta_by * log.matrix("theta"), log.matrix("f")
    return dataset_from_arrays(neck, frames.time, frames.matrix("alpha"), log.time, theta, f, frames.matrix("sigma"))


@pytest.mark.parametrize("neck", [NECK, CONVERTED], ids=["log in SI units", "log in units of its own"])
def test_series_of_a_data_set_make_it_again(neck: Neck, data: DataSet) -> None:
    made = again(neck, data)
    for stem in ("alpha", "theta", "f"):
        np.testing.assert_array_equal(made.state.matrix(stem), data.state.matrix(stem))
    np.testing.assert_array_equal(made.log.matrix("theta"), data.log.matrix("theta"))
    assert made.neck == neck
    assert made.check["verdict"] == data.check["verdict"] == "consistent"


def test_arrays_as_they_were_logged_are_refused_by_what_is_to_be_done_with_them(data: DataSet) -> None:
    says = r"theta is in degrees.*convert the arrays, or let xneck\.read_log read the log's file"
    with pytest.raises(Refused, match=says):
        again(CONVERTED, data, np.degrees(1.0))


def test_times_of_arrays_are_not_to_be_scaled_by_the_description(data: DataSet) -> None:
    """Its time_scale is for files: what was to be written there changed nothing."""
    log, frames = data.log, data.angles
    with pytest.raises(
        Refused, match=r"time is in milliseconds.*; convert the arrays, or let xneck\.read_log"
    ) as refusal:
        dataset_from_arrays(
            NECK, frames.time, frames.matrix("alpha"), 1e3 * log.time, log.matrix("theta"), log.matrix("f")
        )
    assert "multiply time by 0.001" in str(refusal.value)
