"""Tables as other programs write them: separators, decimals, times, titles; each is read, or its true reason is said."""

from pathlib import Path

import numpy as np
import pytest

from identification.dataset.series import Series, check_time
from mechanism.arm import arm_of
from mechanism.description import read_neck
from synchronisation.angles import read_angles
from synchronisation.column_meaning import column_meaning
from synchronisation.encoder_log import read_log
from synchronisation.log_contents import read_contents
from synchronisation.log_mapping import LogMapping, map_log, mapped_neck
from synchronisation.log_plausibility import check_log_meaning
from tests.paths import SAMPLES
from tests.synchronisation.test_any_log import NECK, truth
from xneck_foundation.errors import Refused

GERMAN = ["Zeit [s]", *(f"Winkel {j} [rad]" for j in (1, 2, 3, 4)), *(f"Kraft {j} [N]" for j in (1, 2, 3, 4))]
OURS = ["time", *(f"theta{j}" for j in (1, 2, 3, 4)), *(f"f{j}" for j in (1, 2, 3, 4))]


def values() -> np.ndarray:
    """Columns time, theta1..4, f1..4 of the log that all of these files hold, shape (T, 9)."""
    series = truth()
    return np.column_stack([series.time, series.matrix("theta"), series.matrix("f")])


def written(
    path: Path,
    *head: str,
    separator: str = ",",
    form: str = "{:.6f}",
    decimal: str = ".",
    table: np.ndarray | None = None,
) -> Path:
    """A file with these first lines and rows below, those of `values` unless others are given."""
    below = values() if table is None else table
    rows = (separator.join(form.format(value).replace(".", decimal) for value in row) for row in below)
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


LONG_UNITS = {"min": ("minutes", 60.0), "h": ("hours", 3600.0), "days": ("days", 86400.0)}


@pytest.mark.parametrize("unit", LONG_UNITS)
def test_minutes_hours_and_days_are_told_by_their_steps(unit: str, tmp_path: Path) -> None:
    word, seconds = LONG_UNITS[unit]
    table = values()
    table[:, 0] /= seconds
    log = written(tmp_path / "log.csv", ",".join(OURS), form="{:.14g}", table=table)
    with pytest.raises(Refused, match=rf"time is in {word}: .*write log: \{{time_scale: {seconds:g}\}}"):
        read_log(log, NECK)
    mapping = mapping_of(log)
    assert mapping.time is not None
    assert (mapping.time.unit, mapping.to_mend) == (unit, ())
    assert mapping.rate == pytest.approx(500, rel=1e-3)
    assert_read_as_mapped(log)


@pytest.mark.parametrize("first", [45352.5, 739312.5])
def test_a_date_as_a_number_is_to_be_brought_near_zero(first: float, tmp_path: Path) -> None:
    table = values()
    table[:, 0] = first + table[:, 0] / 86400
    log = written(tmp_path / "log.csv", ",".join(OURS), form="{:.16g}", table=table)
    with pytest.raises(Refused, match=r"time is in days: .*subtract the first time from all, and multiply by 86400"):
        read_log(log, NECK)
    mapping = mapping_of(log)
    assert mapping.time is not None
    assert mapping.time.unit == "days"
    assert "subtract the first time from all" in mapping.to_mend[0]
    with pytest.raises(Refused, match="subtract the first time from all"):
        read_log(log, mapped_neck(NECK, mapping))


def test_a_rate_that_no_controller_has_is_doubted(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", ",".join(["time [us]", *OURS[1:]]))
    assert "which no controller writes" in mapping_of(log).doubts[0]


@pytest.mark.parametrize("rows", [3, 40])
def test_a_log_of_a_moment_is_too_short_and_no_more(rows: int) -> None:
    neck, angles = read_neck(SAMPLES / "held_out/neck.yaml"), read_angles(SAMPLES / "held_out/angles.csv", 3)
    log = read_log(SAMPLES / "held_out/log.mcap", neck)
    turned = {name: values for name, values in log.part(slice(0, rows)).columns.items() if name[0] == "t"}
    assert check_log_meaning(neck, arm_of(neck), angles, Series(log.time[:rows], turned)) == ()


def with_further(path: Path, stem: str, after: bool) -> Path:
    """The log with four columns beside the angles that hold something else, before or after them."""
    table, further = values(), [stem.format(j) for j in (1, 2, 3, 4)]
    at = 5 if after else 1
    names, mixed = [*OURS[:at], *further, *OURS[at:]], np.insert(table, [at] * 4, 0.3 * table[:, 1:5] + 7, axis=1)
    path.write_text("\n".join([",".join(names), *(",".join(f"{v:.8g}" for v in row) for row in mixed), ""]))
    return path


BESIDE = (
    *(f"theta{{}}{end}" for end in ("_dot", "dot", "_v", "_p", "_err", "_r", "_ref", "_offset", "_vel")),
    *(f"f{{}}_{end}" for end in ("meas", "ist", "act", "sensor", "x")),
    "dtheta{}/dt",
)


@pytest.mark.parametrize("after", [True, False])
@pytest.mark.parametrize("stem", BESIDE)
def test_what_stands_beside_angles_and_commands_is_not_taken_for_them(stem: str, after: bool, tmp_path: Path) -> None:
    log = with_further(tmp_path / "log.csv", stem, after)
    mapping = mapping_of(log)
    assert [c.name for c in (*mapping.angles, *mapping.forces)] == OURS[1:]


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("theta1_dot", "speed"),
        ("theta2dot", "speed"),
        ("theta1_err", "error"),
        ("torque_offset_1", "error"),
        ("Drehzahl 1", "speed"),
    ],
)
def test_speeds_and_errors_are_known_by_their_names(name: str, kind: str) -> None:
    assert column_meaning(name, np.array([0.1, 0.7, 0.4])).kind == kind


def test_forces_that_were_measured_are_taken_where_no_others_stand_and_that_is_said(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", ",".join([*OURS[:5], *(f"f{j}_meas" for j in (1, 2, 3, 4))]))
    mapping = mapping_of(log)
    assert [f.name for f in mapping.forces] == [f"f{j}_meas" for j in (1, 2, 3, 4)]
    assert any("are measured by their names: the commanded ones are needed" in doubt for doubt in mapping.doubts)
    assert not any("commanded ones" in doubt for doubt in mapping_of(written(log, ",".join(OURS))).doubts)


LABVIEW = (
    "LabVIEW Measurement",
    "Writer_Version\t2",
    "Separator\tTab",
    "Decimal_Separator\t.",
    "***End_of_Header***",
    "",
)
TITLES = {
    "LabVIEW": (LABVIEW, "\t", 7),
    "of a spreadsheet": (("Experiment 3,,,,,,,,", "Operator,Meier,,,,,,,", ",,,,,,,,"), ",", 4),
    "unlike the table": (("Experiment 3;;;;", "Operator,Meier", ""), ",", 4),
    "with a number": (("Motion of 2024", "rate,500"), ";", 3),
}


@pytest.mark.parametrize("title", TITLES)
def test_lines_above_the_header_are_the_reason_that_is_said(title: str, tmp_path: Path) -> None:
    lines, separator, row = TITLES[title]
    log = written(tmp_path / "log.csv", *lines, separator.join(OURS), separator=separator)
    for read in (lambda: read_log(log, NECK), lambda: read_contents(log)):
        with pytest.raises(Refused, match=f"its header is in row {row}, below .* of something else") as refusal:
            read()
        assert "xneck logs" not in str(refusal.value)


def test_lines_that_begin_with_a_percent_sign_are_comments(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", "% recorded by the controller", "% arm 2, motion 4", ",".join(OURS))
    assert len(read_log(log, NECK)) == len(values())
    assert_read_as_mapped(log)


def test_rows_without_numbers_at_the_beginning_are_no_titles(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", ",".join(OURS), *[",".join(["NULL"] * 9)] * 3)
    with pytest.raises(Refused, match="row 2, column time: 'NULL' is not a number"):
        read_log(log, NECK)


def test_a_number_of_each_row_is_no_time(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    rows = [",".join([str(k), *(f"{value:.8g}" for value in row[1:])]) for k, row in enumerate(values())]
    log.write_text("\n".join([",".join(["Sample", *OURS[1:]]), *rows, ""]))
    with pytest.raises(Refused, match="no column is a time: Sample counts rows; log the time of each row"):
        mapping_of(log)


def test_a_column_that_is_taken_for_the_time_as_it_grows_is_said(tmp_path: Path) -> None:
    mapping = mapping_of(written(tmp_path / "log.csv", ",".join(["x", *OURS[1:]])))
    assert mapping.doubts[0] == "which column is the time: x is taken for it, as it grows evenly"


RECEIVED = np.cumsum(np.where(np.arange(len(truth())) % 10, 1e-5, 0.02 - 9e-5))
SEVERAL_TIMES = {
    "whole seconds": ("timestamp", 1.7e9 + np.floor(truth().time)),
    "in bursts": ("time_received", 1.7e9 + RECEIVED),
    "rows": ("tick", np.arange(float(len(truth())))),
}


@pytest.mark.parametrize("other", SEVERAL_TIMES)
@pytest.mark.parametrize("first", [True, False])
def test_of_several_times_that_of_the_samples_is_taken_and_it_is_said(
    other: str, *, first: bool, tmp_path: Path
) -> None:
    name, beside = SEVERAL_TIMES[other]
    sampled = 1e3 * values()[:, 0]
    times = [beside, sampled] if first else [sampled, beside]
    names = [name, "elapsed"] if first else ["elapsed", name]
    table = np.column_stack([*times, values()[:, 1:]])
    log = written(tmp_path / "log.csv", ",".join([*names, *OURS[1:]]), table=table)
    assert_read_as_mapped(log)
    assert mapping_of(log).doubts[0] == (
        f"which of several times is that of the samples: elapsed is taken, and not {name}"
    )


def test_whole_seconds_are_in_no_unit_of_their_own() -> None:
    time = np.arange(0, 20, 0.002)
    assert column_meaning("timestamp", 1.7e9 + np.floor(time)).unit == "s"
    assert column_meaning("timestamp", 1e3 * np.round(time, 2)).unit == "ms"


SET_CLOCKS = {
    "midnight": (86390.0, -86400, "as seconds of a day do at midnight; add 86400 to time in that row and all below it"),
    "winter": (1.7e9, -3600, "by an hour, as where summer time ends; add 3600 to time in that row"),
    "summer": (1.7e9, 3600, "by an hour, as where summer time begins; subtract 3600 from time in that row"),
    "a day": (1.7e9, 86400, "by a day: the clock's date was set; subtract 86400 from time in that row"),
}


@pytest.mark.parametrize("when", SET_CLOCKS)
def test_a_clock_that_was_set_on_the_way_is_called_that_with_the_number_to_add(when: str, tmp_path: Path) -> None:
    begins, jump, says = SET_CLOCKS[when]
    table = values().copy()
    table[:, 0] += begins - table[0, 0]
    row = len(table) // 2
    table[row:, 0] += jump
    log = written(tmp_path / "log.csv", ",".join(OURS), table=table)
    before, after = np.round(table[row - 1 : row + 1, 0], 6)
    stamps = f"row {row + 2}, from {before:.13g} to {after:.13g}, "
    reads = [lambda: read_log(log, NECK), *([lambda: mapping_of(log)] if jump < 0 else [])]
    for read in reads:
        with pytest.raises(Refused, match=f"{stamps}{says}"):
            read()


@pytest.mark.parametrize("jump", [3590.0, 3610.0, 20.0])
def test_a_pause_of_another_length_is_no_clock_that_was_set(jump: float) -> None:
    time = np.r_[np.arange(0, 1000, 0.02), 1000 + jump + np.arange(0, 1000, 0.02)]
    check_time(time, "log")


@pytest.mark.parametrize("date", ["05-Mar-2024 23:59:50.000", "5-Mrz.-2024 23:59", "2024-03-05 23:59:50"])
def test_a_column_of_dates_is_named_where_no_other_may_be_the_time(date: str, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    rows = [",".join([date, *(f"{value:.8g}" for value in row[1:])]) for row in values()]
    log.write_text("\n".join([",".join(["Datum", *OURS[1:]]), *rows, ""]))
    with pytest.raises(Refused, match=r"row 2, column Datum: .* is a date; write the time in seconds"):
        mapping_of(log)


JOINED = {
    "time begins again": (lambda rows: [*rows, *rows], f"time begins again in row {len(truth()) + 2}"),
    "the header again": (lambda rows: [*rows, ",".join(OURS), *rows], f"header stands again in row {len(truth()) + 2}"),
}


@pytest.mark.parametrize("how", JOINED)
def test_two_recordings_in_one_file_are_called_that(how: str, tmp_path: Path) -> None:
    join, says = JOINED[how]
    rows = [",".join(f"{value:.8g}" for value in row) for row in values()]
    log = tmp_path / "log.csv"
    log.write_text("\n".join([",".join(OURS), *join(rows), ""]))
    for read in (lambda: read_log(log, NECK), lambda: mapping_of(log)):
        with pytest.raises(Refused, match=f"{says}.*as where two recordings are joined; cut them apart there"):
            read()


@pytest.mark.parametrize(("bits", "tick_s"), [(32, 1e-6), (16, 1e-3)])
def test_a_time_whose_counter_runs_over_is_called_that(bits: int, tick_s: float, tmp_path: Path) -> None:
    """It was said to be two recordings joined, to be cut apart."""
    table = values()[:2000].copy()
    ticks = np.round((table[:, 0] - table[1000, 0]) / tick_s + 1000 * (tick_s < 1e-4)) % 2**bits
    log = written(tmp_path / "log.csv", ",".join(OURS), table=np.column_stack([ticks, table[:, 1:]]))
    with pytest.raises(
        Refused, match=f"time runs over in row 100[0-2], as a counter of {bits} bits does; add {2**bits}"
    ):
        mapping_of(log)


def test_rows_that_are_written_twice_are_no_damaged_row(tmp_path: Path) -> None:
    """The time goes back there, and goes on."""
    table = values()[:2000]
    log = written(tmp_path / "log.csv", ",".join(OURS), table=np.concatenate([table[:1500], table[500:]]))
    with pytest.raises(
        Refused, match=r"time goes back by .* in row 1502, and grows on from there; are rows written twice"
    ):
        mapping_of(log)


@pytest.mark.parametrize("cell", ["#N/A", "#DIV/0!", "NA", "null", "-"])
def test_cells_that_say_that_a_number_is_missing_are_answered_with_what_to_do(cell: str, tmp_path: Path) -> None:
    rows = [[f"{value:.8g}" for value in row] for row in values()]
    rows[100][6] = cell
    log = tmp_path / "log.csv"
    log.write_text("\n".join([",".join(OURS), *map(",".join, rows), ""]))
    with pytest.raises(Refused, match=r"row 102, column f2: .*; leave such rows out"):
        read_log(log, NECK)
    assert mapping_of(log).to_mend == ("1 row without a number in f2, the first is 102: leave such rows out",)


def test_a_tdms_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "log.tdms").write_bytes(b"TDSm" + bytes(range(256)))
    with pytest.raises(Refused, match="is no CSV but a TDMS file, as LabVIEW writes them; export it as CSV"):
        read_log(tmp_path / "log.tdms", NECK)


@pytest.mark.parametrize("names", ["sec,nanosec", "secs,nsecs", "header.stamp.sec,header.stamp.nanosec"])
def test_stamps_that_are_parted_in_seconds_and_nanoseconds_are_put_together(tmp_path: Path, names: str) -> None:
    whole = np.floor(values()[:, 0])
    parted = np.column_stack([whole, np.round(1e9 * (values()[:, 0] - whole)), values()[:, 1:]])
    assert whole[-1] > whole[0]
    motors = ",".join(f"theta{j + 1}" for j in range(NECK.M)) + "," + ",".join(f"f{j + 1}" for j in range(NECK.M))
    log = written(tmp_path / "log.csv", f"{names},{motors}", table=parted, form="{:.12g}")
    assert mapping_of(log).rate == pytest.approx(500)
    assert_read_as_mapped(log)


def test_a_table_of_latin_1_is_read_and_one_of_bytes_that_are_no_text_is_not(tmp_path: Path) -> None:
    motors = ";".join(f"Winkel{j + 1} [\N{DEGREE SIGN}]" for j in range(NECK.M))
    names = f"Zeit [s];{motors};" + ";".join(f"Zugkraft, gewünscht {j + 1} [N]" for j in range(NECK.M))
    degrees = np.column_stack([values()[:, 0], np.degrees(values()[:, 1 : 1 + NECK.M]), values()[:, 1 + NECK.M :]])
    log = written(tmp_path / "log.csv", names, separator=";", decimal=",", table=degrees)
    text = log.read_text(encoding="utf-8")
    log.write_bytes(text.encode("latin-1"))
    assert_read_as_mapped(log)
    log.write_bytes(text.encode("latin-1").replace(b"0", b"\x01"))
    with pytest.raises(Refused, match="not UTF-8 text"):
        read_contents(log)


def test_a_table_with_the_latest_row_on_top_is_named(tmp_path: Path) -> None:
    motors = [f"{stem}{j + 1}" for stem in ("theta", "f") for j in range(NECK.M)]
    log = written(tmp_path / "log.csv", ",".join(["time", *motors]), table=values()[::-1])
    for read in (lambda: read_log(log, NECK), lambda: mapping_of(log)):
        with pytest.raises(Refused, match="time runs backwards, from the first row to the last; sort the rows"):
            read()
