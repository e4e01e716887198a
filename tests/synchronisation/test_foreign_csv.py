"""Tables as other programs write them: separators, decimals, units, titles; each is read, or its true reason is said."""

import re
from pathlib import Path

import numpy as np
import pytest

from synchronisation.encoder_log import read_log
from synchronisation.log_contents import read_contents
from synchronisation.log_mapping import LogMapping, map_log, mapped_neck
from tests.synchronisation.test_any_log import NECK, truth
from xneck_foundation.errors import Refused

GERMAN = ["Zeit [s]", *(f"Winkel {j} [rad]" for j in (1, 2, 3, 4)), *(f"Kraft {j} [N]" for j in (1, 2, 3, 4))]
OURS = ["time", *(f"theta{j}" for j in (1, 2, 3, 4)), *(f"f{j}" for j in (1, 2, 3, 4))]


def values() -> np.ndarray:
    """Columns time, theta1..4, f1..4 of the log that all of these files hold, shape (T, 9)."""
    series = truth()
    return np.column_stack([series.time, series.matrix("theta"), series.matrix("f")])


def written(path: Path, *head: str, separator: str = ",", form: str = "{:.6f}", decimal: str = ".") -> Path:
    """A file with these first lines and the rows of `values` below."""
    rows = (separator.join(form.format(value).replace(".", decimal) for value in row) for row in values())
    path.write_text("\n".join([*head, *rows, ""]), encoding="utf-8")
    return path


def mapping_of(log: Path) -> LogMapping:
    return map_log(log, read_contents(log), NECK.M)


def assert_read_as_mapped(log: Path) -> None:
    """What `xneck logs` writes into neck.yaml makes the log what it was."""
    found = read_log(log, mapped_neck(NECK, mapping_of(log)))
    read = np.column_stack([found.time, found.matrix("theta"), found.matrix("f")])
    np.testing.assert_allclose(read, values(), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("form", ["{:.6f}", "{:.8E}", "{:.10g}"])
@pytest.mark.parametrize(("separator", "word"), [(";", "semicolons"), ("\t", "tabs")])
@pytest.mark.parametrize("header", [GERMAN, OURS])
def test_decimal_commas_are_no_separators_though_more_of_them_stand_there(
    separator: str, word: str, form: str, header: list[str], tmp_path: Path
) -> None:
    log = written(tmp_path / "log.csv", separator.join(header), separator=separator, form=form, decimal=",")
    assert_read_as_mapped(log)
    with pytest.raises(Refused, match=f"parted by {word}, and its numbers have decimal commas"):
        read_log(log, NECK)


def test_a_date_with_commas_is_named_as_it_stands_there(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    rows = [f"01,03,2024 23:59:50,{k:03d};1,{k:04d};2,5" for k in range(100)]
    log.write_text("\n".join(["time;theta1;theta2", *rows, ""]))
    with pytest.raises(Refused, match=r"column time: '01,03,2024 23:59:50,000' is a date; write the time in seconds"):
        map_log(log, read_contents(log), None)
    with pytest.raises(Refused, match="parted by semicolons, and its numbers have decimal commas"):
        read_log(log, NECK)
