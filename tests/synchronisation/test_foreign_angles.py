"""Angles as other programs write them: all that is to be changed is said at once, and of sigma where it stands."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from synchronisation.angles import read_angles
from xneck_foundation.errors import Refused

FRAMES = 60
OURS = ["time", "alpha1", "alpha2", "alpha3"]
SIGMAS = ["sigma1", "sigma2", "sigma3"]


def rows() -> list[list[str]]:
    time = np.arange(FRAMES) / 30
    angles = (0.3 * np.sin((1 + j) * time) for j in range(3))
    return [[f"{value:.6f}" for value in row] for row in np.column_stack([time, *angles])]


def written(path: Path, header: list[str], table: list[list[str]], separator: str = ",", decimal: str = ".") -> Path:
    lines = [separator.join(header), *(separator.join(cell.replace(".", decimal) for cell in row) for row in table), ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("header", "says"),
    [
        (
            ["Time (s)", "Joint 1 (deg)", "Joint 2 (deg)", "Joint 3 (deg)"],
            r"time 'Time \(s\)', alpha1 'Joint 1 \(deg\)', .*alpha3.*write time,alpha1,alpha2,alpha3 just so, "
            r"and multiply alpha1\.\.N by 0\.0174533 \(deg\)",
        ),
        (["t", "θ1", "θ2", "θ3"], "calls time 't', alpha1 'θ1', .*write time,alpha1,alpha2,alpha3 just so"),
        (["time_ms", *OURS[1:]], r"calls time 'time_ms'; write time just so, and multiply time by 0\.001 \(ms\)"),
        (["frame", *OURS[1:]], "lacks the column time: frame is a number of each row; write the time of each row"),
    ],
)
def test_names_and_units_of_all_columns_are_said_at_once(header: list[str], says: str, tmp_path: Path) -> None:
    with pytest.raises(Refused, match=says):
        read_angles(written(tmp_path / "angles.csv", header, rows()), 3)


def test_names_behind_semicolons_are_said_with_them(tmp_path: Path) -> None:
    header = ["Time (s)", "Joint 1 (deg)", "Joint 2 (deg)", "Joint 3 (deg)"]
    file = written(tmp_path / "angles.csv", header, rows(), separator=";", decimal=",")
    with pytest.raises(Refused, match=r"parted by semicolons.*decimal commas; its header calls time .*\(deg\)$"):
        read_angles(file, 3)


@pytest.mark.parametrize(
    ("cell", "says"),
    [
        ("0", r"sigma2 is 0 in row 12: no angle is without error"),
        ("", r"sigma2 is missing in row 12, where alpha2 is"),
        ("-0.001", r"sigma2 is -0\.001 in row 12, and standard deviations are above 0"),
        ("1000", r"sigma2 is 1000 in row 12, .*up to 6\.28319 rad"),
        ("inf", r"sigma2 is inf in row 12"),
    ],
)
def test_a_sigma_that_cannot_be_one_is_named_where_it_stands(cell: str, says: str, tmp_path: Path) -> None:
    table = [[*row, "0.001", "0.001", "0.001"] for row in rows()]
    table[10][5] = cell
    with pytest.raises(Refused, match=says):
        read_angles(written(tmp_path / "angles.csv", [*OURS, *SIGMAS], table), 3)


@pytest.mark.parametrize("cell", ["0", "inf", "nan", "-1", ""])
def test_what_stands_in_sigma_without_an_angle_has_no_say(cell: str, tmp_path: Path) -> None:
    table = [[*row, "0.001", "0.001", "0.001"] for row in rows()]
    table[10][1:] = ["", "", "", cell, cell, cell]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        angles = read_angles(written(tmp_path / "angles.csv", [*OURS, *SIGMAS], table), 3)
    assert np.isnan(angles.sigma[10]).all()
    assert np.isfinite(np.delete(angles.sigma, 10, axis=0)).all()
