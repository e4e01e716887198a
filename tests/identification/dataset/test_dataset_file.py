"""A data set reads back as it was written, in our format and in other people's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from identification.dataset.dataset import DataSet, state_series
from identification.dataset.dataset_file import export_series, read_dataset, write_dataset
from identification.dataset.series import Series, numbered_columns
from identification.files import joint_state
from mechanism.arm import arm_of
from mechanism.description import read_neck
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

NECK = NECK_FILE


def thrice(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same for a signal and its derivatives: only the file is at stake here."""
    return values, values, values


@pytest.fixture
def data() -> DataSet:
    neck = read_neck(NECK)
    t = 0.002 * np.arange(300, dtype=float)
    alpha = 0.2 * np.sin(np.outer(t, [1.0, 2.0, 3.0]))
    theta = np.sin(np.outer(t, [1.0, 2.0, 3.0, 4.0]))
    state = state_series(arm_of(neck), t, thrice(alpha), thrice(theta), 40 + theta, thrice(alpha**2))
    angles = Series(t[::16], numbered_columns("alpha", alpha[::16]))
    log = Series(t, numbered_columns("theta", theta) | numbered_columns("f", 40 + theta))
    return DataSet(
        neck=neck,
        neck_yaml=NECK.read_text(),
        state=state,
        fasquelle=state,
        angles=angles,
        log=log,
        clock={"offset_s": 1.5},
        check={"verdict": "consistent"},
        provenance={},
    )


def test_round_trip(tmp_path: Path, data: DataSet) -> None:
    write_dataset(data, tmp_path / "d.mcap")
    back = read_dataset(tmp_path / "d.mcap")
    assert back.neck == data.neck
    assert (back.clock, back.check) == (data.clock, data.check)
    for part in ("state", "fasquelle", "angles", "log"):
        one, other = getattr(data, part), getattr(back, part)
        assert list(one.columns) == list(other.columns)
        np.testing.assert_allclose(other.time, one.time, atol=1e-9)
        for name, values in one.columns.items():
            np.testing.assert_array_equal(other.columns[name], values)


def test_columns_are_those_of_the_contract(data: DataSet) -> None:
    expected = [f"alpha{i}{d}" for d in ("", "_d", "_dd") for i in (1, 2, 3)]
    expected += [f"theta{j}{d}" for d in ("", "_d", "_dd") for j in (1, 2, 3, 4)]
    expected += [f"f{j}" for j in (1, 2, 3, 4)] + [f"x{j}" for j in (1, 2, 3, 4)]
    expected += [f"sigma_alpha{i}{d}" for d in ("", "_d", "_dd") for i in (1, 2, 3)]
    assert list(data.state.columns) == expected


@pytest.mark.parametrize("suffix", ["csv", "npz", "mat"])
def test_exports_hold_the_same_numbers(tmp_path: Path, data: DataSet, suffix: str) -> None:
    data.state.columns["alpha1"][5] = np.nan  # type: ignore[index]
    file = tmp_path / f"d.{suffix}"
    export_series(data.state, file)
    if suffix == "csv":
        table = np.genfromtxt(file, delimiter=",", names=True)
        found = {name: table[name] for name in table.dtype.names or ()}
    elif suffix == "npz":
        found = dict(np.load(file))
    else:
        found = {name: np.ravel(values) for name, values in loadmat(file).items() if not name.startswith("_")}
    assert set(found) == {"time", *data.state.columns}
    for name, values in data.state.columns.items():
        np.testing.assert_array_equal(found[name], values)


def test_another_mcap_is_not_a_data_set(tmp_path: Path, data: DataSet) -> None:
    joint_state.write(tmp_path / "a.mcap", {"angles": data.angles}, {})
    with pytest.raises(Refused, match="not a data set"):
        read_dataset(tmp_path / "a.mcap")


def test_unknown_formats_are_refused_with_the_valid_ones(tmp_path: Path, data: DataSet) -> None:
    with pytest.raises(Refused, match="csv, npz, mat"):
        export_series(data.state, tmp_path / "d.xlsx")
    assert list(tmp_path.iterdir()) == []


def test_an_elongation_is_what_the_winding_adds(data: DataSet) -> None:
    """Turning a motor by a radian at rest stretches its cable by rd/R, whatever the arm's pose."""
    arm = data.arm
    alpha, zero = np.full((1, 3), 0.3), np.zeros((1, 4))
    held = state_series(arm, np.zeros(1), thrice(alpha), thrice(zero), zero).matrix("x")
    turned = state_series(arm, np.zeros(1), thrice(alpha), thrice(zero + 1.0), zero).matrix("x")
    np.testing.assert_allclose(turned - held, 0.010 / 25, rtol=1e-9)
    assert replace(data, clock={}).arm.M == 4
