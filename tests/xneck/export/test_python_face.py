"""What Python users do with results: tables, other numbers, words and records."""

import pickle
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import xneck
from identification.dataset.dataset import DataSet, state_series
from identification.dataset.dataset_file import export_series
from identification.dataset.series import Series
from identification.design.trajectory import tension_levels
from identification.model_file import covariance_of, machine_of
from mechanism.arm import arm_of
from mechanism.cable_lengths import Z
from mechanism.dynamics import gravity_and_springs
from tests.command import run
from tests.paths import NECK_FILE
from tests.xneck.export.test_mujoco_file import model
from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import replacing_any_file, write_text

NECK = xneck.read_neck(NECK_FILE)
TIME = np.arange(200) / 500.0
FACE: Any = xneck
"""for arguments that a type checker would refuse"""
ANY_MODEL: Any = model()


@pytest.fixture(scope="module")
def data() -> DataSet:
    """A data set of arrays that are nobody's motion."""
    alpha = 0.1 * np.sin(np.outer(TIME, [5.0, 6.0, 7.0]))
    theta = 10 * np.sin(np.outer(TIME, [5.0, 6.0, 7.0, 8.0]))
    still, motors_still = np.zeros_like(alpha), np.zeros_like(theta)
    motion = (alpha, still, still), (theta, motors_still, motors_still)
    state = state_series(arm_of(NECK), TIME, *motion, 40 + theta)
    empty = Series(np.empty(0), {})
    return DataSet(neck=NECK, neck_yaml="", state=state, fasquelle=state, angles=empty, log=empty)


def test_a_data_set_prints_in_one_line(data: DataSet) -> None:
    assert repr(data) == "<DataSet of 3 joints and 4 cables: 0.4 s, 200 rows, 0 frames>"


def test_arrays_are_the_state(data: DataSet) -> None:
    arrays = xneck.to_arrays(data)
    assert next(iter(arrays)) == "time"
    np.testing.assert_array_equal(arrays["theta2"], data.state.columns["theta2"])


def test_pandas_and_xarray_hold_the_same(data: DataSet) -> None:
    pandas, xarray = (pytest.importorskip(name) for name in ("pandas", "xarray"))
    table, cube = xneck.to_pandas(data), xneck.to_xarray(data)
    assert isinstance(table, pandas.DataFrame)
    assert isinstance(cube, xarray.Dataset)
    np.testing.assert_array_equal(table["f3"].to_numpy(), data.state.columns["f3"])
    assert table.index.name == "time"
    np.testing.assert_array_equal(cube["theta"].sel(cable=4).to_numpy(), data.state.columns["theta4"])
    assert cube["alpha"].dims == ("time", "joint")
    assert cube["alpha_d"].shape == (200, 3)
    assert cube["x"].dims == ("time", "cable")


@pytest.mark.parametrize("name", ["pandas", "xarray"])
def test_a_library_that_lacks_is_one_line(name: str, data: DataSet, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(
        Refused, match=f"^to_{name}: {name} is not installed; pip install {name}, or take xneck.to_arrays$"
    ):
        getattr(xneck, f"to_{name}")(data)


def test_a_model_with_other_numbers() -> None:
    base = model().model_copy(update={"covariance": tuple(tuple(float(i + j + 1) for i in range(4)) for j in range(4))})
    changed = base.with_(k=8000.0, fs=12.0)
    machine = machine_of(changed, arm_of(NECK))
    assert machine.values["k"].tolist() == [8000.0] * 4
    assert machine.values["fs"].tolist() == [12.0] * 4
    assert machine_of(base, arm_of(NECK)).values["k"].tolist() == [9000.0] * 4, "the model itself is as it was"
    # what was set is exact, and the rest covaries as before
    covariance = covariance_of(changed)
    places = [p.name for p in changed.parameters]
    exact = [places.index("k"), places.index("fs")]
    assert not covariance[exact].any()
    assert not covariance[:, exact].any()
    kept = [places.index("cm"), places.index("ca")]
    np.testing.assert_array_equal(covariance[np.ix_(kept, kept)], covariance_of(base)[np.ix_(kept, kept)])


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"kk": 1.0}, "unknown parameter 'kk'"),
        ({"k": [1.0, 2.0]}, "2 values for 1"),
        ({"k": np.nan}, "is no number"),
        ({"k": -5.0}, "k of -5 N/m cannot be; give a number above 0$"),
        ({"k": 0.0}, "k of 0 N/m cannot be"),
        ({"fs": -10.0}, "fs of -10 N cannot be; give 0 or more$"),
    ],
)
def test_a_model_without_such_a_number_refuses(values: dict[str, float], words: str) -> None:
    with pytest.raises(Refused, match=words):
        model().with_(**values)


def test_an_arm_with_other_numbers() -> None:
    changed = NECK.with_({"mechanisms[1].L": 0.11, "mechanisms.top.mass": 0.06, "gravity": np.array([0.5, -9.8])})
    assert [m.L for m in changed.mechanisms] == [NECK.mechanisms[0].L, 0.11, NECK.mechanisms[2].L]
    assert [m.top.mass for m in changed.mechanisms] == [0.06] * 3
    assert changed.gravity == (0.5, -9.8)
    assert NECK.with_({}) == NECK
    right = NECK.with_({"mechanisms[0].springs.right": {"stiffness": 300.0, "free_length": 0.05}})
    assert right.mechanisms[0].springs.sides[1].stiffness == 300.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mechanisms[7].L": 0.1}, r"has no mechanisms\[7\].L"),
        ({"mechanisms[x].L": 0.1}, r"has no mechanisms\[x\].L"),
        ({"mechanisms[0].M": 0.1}, "M"),
        ({"mechanisms[0].L": 50.0}, "50"),
        ({"gravity.x": 0.1}, "has no gravity.x"),
        ({"mechanisms[2].top.mas": 0.1}, r"mechanisms\[2\].top.mas: unknown key, did you mean mass\?$"),
    ],
)
def test_an_arm_that_is_none_refuses(changes: dict[str, float], words: str) -> None:
    with pytest.raises(Refused, match=words):
        NECK.with_(changes)


def test_results_have_words_and_records(data: DataSet) -> None:
    """Those that the examples of the face do not show."""
    assert "k = 9000 N/m" in xneck.in_words(model())
    assert xneck.as_record(model())["laws"] == ["dry_friction", "linear_cable"]
    assert "mechanisms:" in xneck.in_words(NECK)
    assert len(xneck.as_record(NECK)["mechanisms"]) == 3
    assert xneck.in_words(data) == "200 samples; no clock of frames"
    for function in (xneck.in_words, xneck.as_record, xneck.figures):
        with pytest.raises(Refused, match="float"):
            function(1.0)


@pytest.mark.parametrize("stiffness", [0.0, -9000.0])
def test_a_number_that_a_law_divides_by_is_refused_where_it_is_not_above_zero(stiffness: float) -> None:
    said = rf"^model: k\(1\) of linear_cable is {stiffness:g}, and must be above zero; "
    with pytest.raises(Refused, match=said):
        machine_of(estimated(k=stiffness), arm_of(NECK))


def test_an_estimate_below_its_range_by_chance_is_taken_at_the_limit() -> None:
    assert machine_of(estimated(fs=-0.1), arm_of(NECK)).values["fs"].tolist() == [0.0] * 4


def test_a_file_that_xneck_did_not_write_is_replaced_from_python_in_a_block(tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_text("mine: 1\n")
    with pytest.raises(Refused, match=r"or write within xneck_foundation\.whole_file\.replacing_any_file\(\)$"):
        xneck.write_model(model(), tmp_path / "model.yaml")
    with replacing_any_file():
        xneck.write_model(model(), tmp_path / "model.yaml")
    assert xneck.read_model(tmp_path / "model.yaml").laws == model().laws


def estimated(**values: float) -> Any:
    """The model with other numbers, as a fit may find them."""
    entries = tuple(p.model_copy(update={"value": values.get(p.name, p.value)}) for p in model().parameters)
    return model().model_copy(update={"parameters": entries})


def still_motion() -> Series:
    """The arm at rest: forces that hold it do not move it."""
    machine = machine_of(model(), arm_of(NECK))
    arm = machine.arm
    level = 50 * tension_levels(arm)[:, 0]
    t = level + np.linalg.pinv(Z(arm, np.zeros(3))) @ gravity_and_springs(arm, np.zeros(3))
    theta = (t / machine.values["k"] - arm.x0) / arm.drum
    assert t.min() > 0
    columns = {f"alpha{i + 1}": np.zeros(200) for i in range(3)}
    columns |= {f"theta{j + 1}": np.full(200, theta[j]) for j in range(4)} | {
        f"f{j + 1}": np.full(200, t[j]) for j in range(4)
    }
    return Series(TIME, columns)


def test_an_arm_that_is_held_stays_and_one_with_a_stronger_motor_does_not() -> None:
    still = still_motion()
    held = xneck.simulate_motion(still, NECK, model())
    assert max(held.rms.values()) < 1e-6
    stronger = replace(still, columns={**still.columns, "f1": still.columns["f1"] + 30})
    assert xneck.simulate_motion(stronger, NECK, model()).rms["alpha1"] > 1e-3


def test_before_anything_is_identified_motors_and_cables_are_like_fasquelles() -> None:
    alike = model().with_(fs=16.8, k=8300.0, ca=0.0, cm=0.5)
    neck = NECK.model_copy(update={"motors": tuple(m.model_copy(update={"fv": 0.0}) for m in NECK.motors)})
    still = still_motion()
    pulled = replace(still, columns={**still.columns, "f1": still.columns["f1"] + 30})
    assumed, given = (xneck.simulate_motion(pulled, neck, by) for by in (None, alike))
    assert assumed.rms["alpha1"] > 1e-3
    assert assumed.rms == pytest.approx(given.rms, rel=1e-6, abs=1e-9)
    assert (assumed.as_json()["model"], given.as_json()["model"]) == ("assumed", "given")
    assert "like Fasquelle's" in assumed.as_text()
    assert "like Fasquelle's" not in given.as_text()


def test_a_motion_in_other_units_of_time_or_with_a_gap_is_refused_before_it_is_simulated(tmp_path: Path) -> None:
    """In milliseconds it would be 1000 times as long, and over a gap its forces would be held."""
    still = still_motion()
    with_gap = still.part(np.abs(TIME - 0.2) > 0.051)
    for motion, says in (
        (Series(1000 * TIME, still.columns), "time is in milliseconds.*multiply time by 0.001$"),
        (with_gap, r"rows are missing before row 7[67], which is 0\.104 s after"),
    ):
        export_series(motion, tmp_path / "motion.csv")
        with pytest.raises(Refused, match=rf"motion\.csv: {says}"):
            xneck.read_motion(tmp_path / "motion.csv", NECK)
        with pytest.raises(Refused, match=f"motion: {says}"):
            xneck.simulate_motion(motion, NECK, model())
        (tmp_path / "motion.csv").unlink()


def test_a_source_that_is_none_is_refused() -> None:
    with pytest.raises(Refused, match="unknown source 'Theta'; did you mean theta"):
        xneck.simulate_motion(still_motion(), NECK, model(), source="Theta")  # type: ignore[arg-type]


def test_the_command_simulates_a_motion(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    motion, out = tmp_path / "motion.csv", tmp_path / "simulated.mcap"
    export_series(still_motion(), motion)
    write_text(tmp_path / "neck.yaml", NECK_FILE.read_text())
    xneck.write_model(model(), tmp_path / "model.yaml")
    words = ("simulate", motion, "--model", tmp_path / "model.yaml", "--out", out)
    ran = run(capfd, *words)
    assert (ran.status, ran.err.count("--neck neck.yaml")) == (1, 1)
    for suffix, head in (("svg", b"<?xml"), ("pdf", b"%PDF"), ("png", b"\x89PNG")):
        picture = tmp_path / f"picture.{suffix}"
        for _ in range(2):  # its own picture is replaced
            ran = run(capfd, *words, "--neck", tmp_path / "neck.yaml", "--picture", picture)
            assert (ran.status, ran.err) == (0, "")
        assert picture.read_bytes().startswith(head)
    ran = run(capfd, *words, "--neck", tmp_path / "neck.yaml", "--picture", tmp_path / "picture.gif")
    assert (ran.status, len(ran.err.splitlines())) == (1, 1)
    motion.write_text(motion.read_text().replace("theta2", "theta9"))
    ran = run(capfd, *words, "--neck", tmp_path / "neck.yaml")
    assert (ran.status, "theta2" in ran.err) == (1, True)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"alpha": np.zeros((50, 2))}, "alpha has the shape"),
        ({"log_time": np.zeros((3, 3))}, "time has the shape"),
        ({"theta": np.zeros((200, 5))}, "theta has the shape"),
        ({"alpha": np.full((50, 3), 90.0)}, "these are degrees"),
        ({"log_time": TIME[::-1]}, "time runs backwards"),
        ({"theta": np.ma.masked_greater_equal(np.zeros((200, 4)), 0.0)}, "theta1 is not a number in row 1;"),
        # a masked value is none, whatever stands below the mask: what is refused is that nothing moves
        ({"alpha": np.ma.masked_equal([[90.0] * 3] + [[0.0] * 3] * 49, 90.0)}, r"are needed|seconds|shows no motion"),
        ({"alpha": np.zeros((50, 3), complex)}, "alpha holds complex numbers"),
        ({"log_time": np.datetime64("2026-11-02") + np.arange(200)}, "time holds dates"),
        ({"f": np.full((200, 4), "x")}, "f holds text"),
        ({"theta": [[0.0], [0.0, 1.0]]}, "theta is no array of numbers"),
    ],
)
def test_arrays_that_are_no_recording_are_refused(change: dict[str, Any], words: str) -> None:
    arrays = {
        "frame_time": np.arange(50) / 30,
        "alpha": np.zeros((50, 3)),
        "log_time": TIME,
        "theta": np.zeros((200, 4)),
        "f": np.zeros((200, 4)),
    }
    with pytest.raises(Refused, match=words):
        xneck.dataset_from_arrays(NECK, **(arrays | change))


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda data: FACE.identify(data), "identify: recordings is a DataSet, expected a list of DataSet; put it into a list"),
        (lambda data: FACE.identify([]), "identify: recordings is empty"),
        (lambda data: FACE.identify(["d.mcap"]), "a list of str, expected a list of DataSet; read it first"),
        (lambda data: FACE.check("d.mcap"), "check: data is 'd.mcap', expected DataSet; read it first: xneck.read_dataset"),
        (lambda data: FACE.check(data, "d.mcap"), "check: baseline is 'd.mcap', expected DataSet or None; read it first"),
        (lambda data: FACE.simulate(data, None), "simulate: model is None, expected Model"),
        (lambda data: FACE.synchronise(["a"]), "synchronise: folder is a list of str, expected str or Path"),
        (lambda data: FACE.simulate(data, model(), "1"), "simulate: window_s is '1', expected float or None"),
        (lambda data: ANY_MODEL.with_(k="a"), "model: k: 'a' is no number"),
        (lambda data: model().with_(k=True), "model: k: 'True' is no number"),
    ],
)  # fmt: skip
def test_arguments_of_another_kind_are_refused_in_one_line(
    call: Callable[[DataSet], object], says: str, data: DataSet
) -> None:
    with pytest.raises(Refused, match=says):
        call(data)


def test_functions_are_those_of_the_face_to_other_processes_too() -> None:
    assert pickle.loads(pickle.dumps(xneck.identify)) is xneck.identify
