"""Commands on damaged input end in a result that is whole, or in one line that names a file and leaves nothing behind."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from identification.dataset.dataset import DataSet
from identification.dataset.dataset_file import dataset_series, read_dataset
from identification.dataset.series import Series
from identification.files import joint_state
from identification.model_file import read_model
from tests.robustness.damage import Damage, of_bytes, of_rows, of_values
from tests.robustness.judge import check, run, some

NUMBER = count()
SERIES = ("state", "fasquelle", "angles", "log")


def place(folder: Path) -> Path:
    """A new folder with an empty one for outputs."""
    made = folder / str(next(NUMBER))
    (made / "out").mkdir(parents=True)
    return made


def damaged(whole: Path, damage: Damage, folder: Path) -> Path:
    (folder / whole.name).write_bytes(damage(whole.read_bytes()))
    return folder / whole.name


@some(12, shrunk=False)
@given(
    case=st.one_of(
        st.tuples(st.sampled_from(["angles.csv", "log.csv"]), st.one_of(of_rows(), of_rows(), of_bytes())),
        st.tuples(st.just("neck.yaml"), st.one_of(of_values(), of_bytes())),
    )
)
def test_sync(case: tuple[str, Damage], recorded: Path, tmp_path: Path) -> None:
    (which, damage), here = case, place(tmp_path)
    files = {name: recorded / name for name in ("angles.csv", "log.csv", "neck.yaml")}
    files[which] = damaged(files[which], damage, here)
    out, result = here / "out/dataset.mcap", here / "out/result.json"
    ran = run(
        f"sync {which}",
        *("sync", files["angles.csv"], files["log.csv"], "--neck", files["neck.yaml"], "--out", out),
        *("--json", result, "--quiet"),
    )
    check(ran, {out: read_dataset, result: readable}, tuple(files.values()))


def readable(path: Path) -> Any:
    return json.loads(path.read_text())


@st.composite
def of_a_dataset(draw: st.DrawFn) -> Callable[[DataSet], DataSet]:
    """What other tools may write into a data set: columns that lack, are constant, are no numbers; a clock that jumps; few rows."""
    name = draw(st.sampled_from(SERIES))
    kind = draw(st.sampled_from(["lack", "value", "cell", "scale", "few", "jump", "clock", "still", "noise"]))
    share = draw(st.floats(0, 1, exclude_max=True))
    at = draw(st.floats(0, 1, exclude_max=True))
    value = draw(st.sampled_from([np.nan, np.inf, 0.0, 1.0, -1.0, 1e6, 1e150, 1e308, -1e308]))
    rows = draw(st.sampled_from([0, 1, 2, 3, 10, 40, 200]))
    seed = draw(st.integers(0, 1000))

    def made(data: DataSet) -> DataSet:
        series: Series = getattr(data, name)
        columns = {key: values.copy() for key, values in series.columns.items()}
        time = series.time.copy()
        column, row = list(columns)[int(share * len(columns))], int(at * len(time))
        if kind == "lack":
            del columns[column]
        elif kind == "value":
            columns[column][:] = value
        elif kind == "cell":
            columns[column][row] = value
        elif kind == "scale":
            with np.errstate(over="ignore"):
                columns[column] *= value if np.isfinite(value) else 1e9
        elif kind == "few":
            columns, time = {key: values[row : row + rows] for key, values in columns.items()}, time[row : row + rows]
        elif kind == "jump":
            time[row:] += abs(value) if np.isfinite(value) and abs(value) < 1e8 else 3600.0
        elif kind == "still":
            for key in columns:
                columns[key][:] = columns[key][row]
        elif kind == "noise":
            columns[column] = np.random.default_rng(seed).normal(size=len(time))
        else:
            key = sorted(data.clock)[int(share * len(data.clock))]
            wrong = {**data.clock, key: [None, "text", -1, 1e300, [], {}][seed % 6]}
            return replace(data, clock=wrong)
        return replace(data, **{name: Series(time, columns)})

    return made


@some(24, shrunk=False)
@given(change=of_a_dataset(), command=st.sampled_from(["check", "identify", "simulate"]))
def test_data_sets_from_elsewhere(
    change: Callable[[DataSet], DataSet], command: str, recorded: Path, tmp_path: Path
) -> None:
    here = place(tmp_path)
    dataset, model = here / "d.mcap", recorded / "m.yaml"
    made = change(read_dataset(recorded / "d.mcap"))
    records = {name: dict(getattr(made, name)) for name in ("clock", "check", "provenance")}
    joint_state.write(dataset, dataset_series(made), records, {"neck.yaml": made.neck_yaml.encode()})
    out = here / "out" / ("m.yaml" if command == "identify" else "s.mcap")
    more = {"check": (), "identify": ("--out", out), "simulate": ("--model", model, "--out", out)}[command]
    ran = run(f"{command} data set", command, dataset, *more, "--json", here / "out/result.json", "--quiet")
    reader = {"check": {}, "identify": {out: read_model}, "simulate": {out: joint_state.read}}[command]
    check(ran, {here / "out/result.json": readable, **reader}, (dataset,))


@some(4, shrunk=False)
@given(damage=st.one_of(of_values(), of_values(), of_bytes()))
def test_models(damage: Damage, recorded: Path, tmp_path: Path) -> None:
    here = place(tmp_path)
    model, out = damaged(recorded / "m.yaml", damage, here), here / "out/s.mcap"
    ran = run("simulate model", "simulate", recorded / "d.mcap", "--model", model, "--out", out, "--quiet")
    check(ran, {out: joint_state.read}, (model,))


def later(row: str, by: float) -> str:
    time, comma, rest = row.partition(",")
    return f"{float(time) + by!r}{comma}{rest}"


def at_time_of(one: str, other: str) -> str:
    return ",".join([one.partition(",")[0], other.partition(",")[2]])


ROWS: dict[str, tuple[Callable[[list[str]], list[str]], str]] = {
    "jumps ahead": (lambda rows: rows[:900] + [later(row, 1e9) for row in rows[900:]], r"time jumps by 1e\+09 s in row 902"),
    "jumps an hour": (lambda rows: rows[:900] + [later(row, 3600) for row in rows[900:]], r"forward in row 902, .* by an hour"),
    "jumps back": (lambda rows: rows[:900] + [later(row, -1) for row in rows[900:]], r"time jumps back in row 902"),
    "stands still": (lambda rows: [*rows[:900], at_time_of(rows[899], rows[900]), *rows[901:]], r"time stands still in row 902"),
    "nanoseconds": (lambda rows: [later(row, 1.7e18) for row in rows], r"time (stands still|of 1\.7e\+18)"),
    "underscore": (lambda rows: [*rows[:9], rows[9].replace(",", ",1_", 1), *rows[10:]], r"column theta1: '1_.*' is not a number"),
    "infinite": (lambda rows: [*rows[:9], "0.018,inf" + ",0" * 7], r"theta1 is not a number in row 11"),
    "beyond": (lambda rows: [*rows[:9], "0.018,1e308" + ",0" * 7], r"theta1 has a value of 1e\+308"),
    "one row": (lambda rows: rows[:1], r"has 1 row;"),
}  # fmt: skip


@pytest.mark.parametrize("name", ROWS)
def test_clocks_and_numbers_of_a_log(name: str, recorded: Path, tmp_path: Path) -> None:
    here, (change, says) = place(tmp_path), ROWS[name]
    header, *rows = (recorded / "log.csv").read_text().splitlines()
    start = float(rows[0].partition(",")[0])
    rows = [later(row, -start) for row in rows]
    (here / "log.csv").write_text("\n".join([header, *change(rows), ""]))
    out = here / "out/d.mcap"
    ran = run(
        "clocks", "sync", recorded / "angles.csv", here / "log.csv", "--neck", recorded / "neck.yaml", "--out", out
    )
    assert ran.status == 1
    check(ran, {out: read_dataset}, (here / "log.csv",))
    assert re.search(rf"log\.csv: .*{says}", ran.err), ran.err


def test_a_clock_may_start_below_zero(recorded: Path, tmp_path: Path) -> None:
    """Of MCAP's own times none is; the messages' stamps are, and what is computed is the same."""
    here = place(tmp_path)
    header, *rows = (recorded / "angles.csv").read_text().splitlines()
    (here / "angles.csv").write_text("\n".join([header, *(later(row, -5.0) for row in rows), ""]))
    out = here / "out/d.mcap"
    ran = run(
        "clocks",
        "sync",
        here / "angles.csv",
        recorded / "log.csv",
        "--neck",
        recorded / "neck.yaml",
        "--out",
        out,
        "--quiet",
    )
    check(ran, {out: read_dataset}, ())
    assert ran.status == 0
    before, after = read_dataset(recorded / "d.mcap"), read_dataset(out)
    np.testing.assert_allclose(after.angles.time, before.angles.time - 5.0, atol=1e-9)
    assert abs(after.clock["offset_s"] - before.clock["offset_s"] - 5.0) < before.clock["offset_sigma_s"]
