"""A log that says its columns' units is not read in others: N of a force in per cent would be no N."""

from pathlib import Path

import numpy as np
import pytest

from mechanism.description import Neck, read_neck
from synchronisation.encoder_log import read_log
from tests.paths import SAMPLES
from xneck.watch.csv_rows import CsvRows
from xneck.watch.growing_file import GrowingFile
from xneck_foundation.errors import Refused

NECK = read_neck(SAMPLES / "recording/neck.yaml")
ANGLES, FORCES = [f"theta{j + 1}" for j in range(NECK.M)], [f"f{j + 1}" for j in range(NECK.M)]


def neck(theta_scale: float = 1.0, f_scale: float = 1.0, time_scale: float = 1.0, **log: object) -> Neck:
    motors = [m.model_copy(update={"theta_scale": theta_scale, "f_scale": f_scale}) for m in NECK.motors]
    read_as = NECK.log.model_copy(update={"units_row": True, "time_scale": time_scale, **log})
    return NECK.model_copy(update={"motors": motors, "log": read_as})


def log(place: Path, units: str | None, names: str = "theta{},f{}", step: float = 0.002) -> Path:
    """A log of a second whose row of units names those of time, angles and forces."""
    angle, force = names.split(",")
    header = ["time", *(angle.format(j + 1) for j in range(NECK.M)), *(force.format(j + 1) for j in range(NECK.M))]
    lines = [",".join(header)]
    if units is not None:
        of_time, of_angle, of_force = units.split(",")
        lines.append(",".join([of_time, *[of_angle] * NECK.M, *[of_force] * NECK.M]))
    for i in range(500):
        lines.append(",".join(f"{value:.6g}" for value in [i * step, *np.sin(i / 100 + np.arange(2 * NECK.M))]))
    path = place / "log.csv"
    path.write_text("\n".join([*lines, ""]))
    return path


@pytest.mark.parametrize(
    ("units", "read_as", "says"),
    [
        ("s,rad,%", neck(), "column f1 is in '%', and motors[].f_scale of neck.yaml is 1"),
        ("s,rad,[%]", neck(), "column f1 is in '%'"),
        ("s,rad,A", neck(), "column f1 is in 'A'"),
        ("s,rad,Nm", neck(), "column f1 is in 'N m'"),
        ("s,rad,kN", neck(), "column f1 is in 'kN', and motors[].f_scale of neck.yaml is 1"),
        ("s,deg,N", neck(), "column theta1 is in 'deg', and motors[].theta_scale of neck.yaml is 1"),
        ("s,counts,N", neck(), "column theta1 is in 'counts', and"),
        ("ms,rad,N", neck(), "column time is in 'ms', and log.time_scale of neck.yaml is 1"),
    ],
)  # fmt: skip
def test_another_unit_is_refused_with_what_to_write(units: str, read_as: Neck, says: str, tmp_path: Path) -> None:
    path = log(tmp_path, units)
    for reading in (lambda: read_log(path, read_as), CsvRows(GrowingFile(path), read_as).new):
        with pytest.raises(Refused) as refused:
            reading()
        assert says in str(refused.value)
        assert "write " in str(refused.value)


@pytest.mark.parametrize(
    ("units", "read_as"),
    [
        ("s,rad,N", neck()),
        ("s,deg,N", neck(theta_scale=0.0174533)),
        ("s,counts,%", neck(theta_scale=2 * np.pi / 2048, f_scale=1.5)),
        ("s,rad,Nm", neck(f_scale=-2500.0)),
        ("s,rad,kN", neck(f_scale=-1000.0)),
        ("s,rad,N", neck(f_scale=-1.0)),
        ("s,rad,N", neck(theta_scale=25.0, f_scale=0.5)),  # angles of the drum, forces that a block halves
        ("s,,-", neck()),
        ("s,motor side,set value", neck()),
    ],
)
def test_the_unit_that_is_meant_is_read_and_what_says_none(units: str, read_as: Neck, tmp_path: Path) -> None:
    path = log(tmp_path, units)
    assert len(read_log(path, read_as)) == 500
    assert CsvRows(GrowingFile(path), read_as).new() is not None


def test_a_name_in_brackets_says_the_unit_too_but_a_letter_may_mean_anything(tmp_path: Path) -> None:
    def named(theta: str, f: str) -> Neck:
        columns = [{"theta_column": theta.format(j + 1), "f_column": f.format(j + 1)} for j in range(NECK.M)]
        motors = [m.model_copy(update=c) for m, c in zip(NECK.motors, columns, strict=True)]
        return NECK.model_copy(update={"motors": motors})

    path = log(tmp_path, None, "angle {} [deg],pull {} [%]")
    with pytest.raises(Refused, match=r"column angle 1 \[deg\] is in 'deg'"):
        read_log(path, named("angle {} [deg]", "pull {} [%]"))
    path = log(tmp_path, None, "angle {} (m),pull {} (a)")
    assert len(read_log(path, named("angle {} (m)", "pull {} (a)"))) == 500
