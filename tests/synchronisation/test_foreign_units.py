"""Units in columns' names and in a row below them: each scales its column, or is said not to be known."""

from pathlib import Path

import numpy as np
import pytest

from synchronisation.column_meaning import column_meaning
from synchronisation.encoder_log import read_log
from synchronisation.log_contents import read_contents
from synchronisation.log_mapping import mapped_neck
from tests.synchronisation.test_any_log import NECK
from tests.synchronisation.test_foreign_csv import OURS, assert_read_as_mapped, mapping_of, values, written
from xneck.watch.csv_rows import CsvRows
from xneck.watch.growing_file import GrowingFile
from xneck_foundation.errors import Refused


def with_names(path: Path, angle: str, force: str, f_by: float = 1.0, theta_by: float = 1.0) -> Path:
    """The log with these names of angles and forces, and its numbers times those that are given."""
    header = ["time", *(angle.format(j) for j in (1, 2, 3, 4)), *(force.format(j) for j in (1, 2, 3, 4))]
    by = np.array([1.0, *[theta_by] * 4, *[f_by] * 4])
    path.write_text("\n".join([",".join(header), *(",".join(f"{v:.9g}" for v in row * by) for row in values()), ""]))
    return path


CURRENTS = (
    "current{}[A]",
    "I_motor{}",
    "I{} [A]",
    "Motor {} Current [A]",
    "i{}",
    "iq{}_A",
    "current_{}_mA",
    "Strom {} [A]",
    "cur{}",
    "torque{}[A]",
)


@pytest.mark.parametrize("name", CURRENTS)
def test_currents_are_no_forces_without_the_motors_torque_constant(name: str, tmp_path: Path) -> None:
    log = with_names(tmp_path / "log.csv", "pos{}[rad]", name)
    mapping = mapping_of(log)
    assert (mapping.forces, [c.name for c in mapping.unscaled]) == ((), [name.format(j) for j in (1, 2, 3, 4)])
    (said,) = [doubt for doubt in mapping.doubts if "forces" in doubt]
    assert "are currents, which the motor's torque constant makes forces: write motors[].f_column" in said
    assert ("0.001" in said) == ("mA" in name)
    assert "f1" not in read_log(log, mapped_neck(NECK, mapping)).columns


GEAR = NECK.motors[0].R / NECK.motors[0].rd
OF_FORCES = {
    "f{}[kgf]": 1 / 9.80665,
    "f{} (kg)": 1 / 9.80665,
    "f{}[g]": 1e3 / 9.80665,
    "f{} [lbf]": 1 / 4.4482216,
    "torque{}[Ncm]": 1e2 / GEAR,
    "tau {} (N mm)": 1e3 / GEAR,
    "tau{}[N*m]": 1 / GEAR,
    "tau{} [oz-in]": 1 / 0.00706155 / GEAR,
    "T{} [Nm]": 1 / GEAR,
}
OF_ANGLES = {"pos{}[U]": 1 / (2 * np.pi), "pos{} [mm]": 1e3 / GEAR, "Position {} (°)": 180 / np.pi}


@pytest.mark.parametrize("name", OF_FORCES)
def test_units_of_forces_in_brackets_get_their_scale(name: str, tmp_path: Path) -> None:
    assert_read_as_mapped(with_names(tmp_path / "log.csv", "pos{}[rad]", name, f_by=OF_FORCES[name]))


@pytest.mark.parametrize("name", OF_ANGLES)
def test_units_of_angles_in_brackets_get_their_scale(name: str, tmp_path: Path) -> None:
    assert_read_as_mapped(with_names(tmp_path / "log.csv", name, "f{}[N]", theta_by=OF_ANGLES[name]))


@pytest.mark.parametrize(
    ("name", "unit"), [("torque{}[%]", "%"), ("f{} (V)", "V"), ("torque{}_pct", "%"), ("tau{} [foo]", "foo")]
)
def test_an_unknown_unit_of_forces_is_said_and_not_taken_for_newtons(name: str, unit: str, tmp_path: Path) -> None:
    mapping = mapping_of(with_names(tmp_path / "log.csv", "pos{}[rad]", name))
    assert mapping.forces == ()
    assert any(f"are in '{unit}', which is no unit that is known" in doubt for doubt in mapping.doubts)


def test_an_unknown_unit_of_angles_is_said(tmp_path: Path) -> None:
    mapping = mapping_of(with_names(tmp_path / "log.csv", "pos{} [foo]", "f{} [N]"))
    assert any("the angles' unit 'foo' is not known" in doubt for doubt in mapping.doubts)


@pytest.mark.parametrize("remark", ["[1]", "(measured)", "(motor side)", "[axis]"])
def test_what_is_no_unit_in_brackets_is_not_taken_for_one(remark: str) -> None:
    found = column_meaning(f"pos2 {remark}", np.array([0.1, 0.7, 0.4]))
    assert (found.kind, found.unit) == ("angle", None)


@pytest.mark.parametrize("name", ["pos1 [rad/s]", "theta1 (deg/s)", "Motor 1 [rpm]", "pos1 [1/min]"])
def test_units_of_speeds_are_known(name: str) -> None:
    assert column_meaning(name, np.array([0.1, 0.7, 0.4])).kind == "speed"


UNITS_BELOW = ("s", *["deg"] * 4, *["N"] * 4)


@pytest.mark.parametrize("form", ["{}", "({})", "[{}]"])
@pytest.mark.parametrize("ends", ["", ","])
def test_a_row_of_units_is_used_and_passed_over(form: str, ends: str, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    by = np.array([1.0, *[180 / np.pi] * 4, *[1.0] * 4])
    rows = [",".join(f"{value:.10g}" for value in row * by) + ends for row in values()]
    head = [",".join(OURS) + ends, ",".join(map(form.format, UNITS_BELOW)) + ends]
    log.write_text("\n".join([*head, *rows, ""]))
    mapping = mapping_of(log)
    assert {a.unit for a in mapping.angles} == {"deg"}
    assert_read_as_mapped(log)
    with pytest.raises(Refused, match=r"row 2 holds no numbers but .*leave that row out; or let `xneck logs log\.csv`"):
        read_log(log, NECK)
    # rows keep the numbers that they have in the file
    log.write_text("\n".join([*head, *rows[:10], rows[10].replace(rows[10].split(",")[1], "nan", 1), *rows[11:], ""]))
    with pytest.raises(Refused, match="theta1 is not a number in row 13"):
        read_log(log, mapped_neck(NECK, mapping))


def test_a_row_of_units_may_have_empty_cells(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    rows = [",".join(f"{value:.10g}" for value in row) + ",1" for row in values()]
    log.write_text("\n".join([",".join([*OURS, "mode"]), "s,rad,rad,rad,rad,N,N,N,N,", *rows, ""]))
    assert read_contents(log).units_row == 2
    assert_read_as_mapped(log)


def test_where_neck_yaml_promises_a_row_of_units_numbers_are_not_passed_over(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", ",".join(OURS))
    promised = NECK.model_copy(update={"log": NECK.log.model_copy(update={"units_row": True})})
    with pytest.raises(Refused, match="row 2 holds numbers, and no units"):
        read_log(log, promised)


def test_a_growing_log_has_its_row_of_units_passed_over_too(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    rows = [",".join(f"{value:.10g}" for value in row) for row in values()]
    log.write_text("\n".join([",".join(OURS), ",".join(UNITS_BELOW), *rows[:10], ""]))
    source = GrowingFile(log)
    grown = CsvRows(source, mapped_neck(NECK, mapping_of(log)))
    first = grown.new()
    with log.open("a") as stream:
        stream.write("\n".join([*rows[10:15], ""]))
    then = grown.new()
    assert first is not None
    assert then is not None
    assert (len(first), len(then)) == (10, 5)
