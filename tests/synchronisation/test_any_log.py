"""Logs with columns, units, signs and formats of their own: what is found in them is what was put in, and they are read alike."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from identification.dataset.series import Series
from mechanism.description import Neck, read_neck
from synchronisation.column_meaning import column_meaning
from synchronisation.encoder_log import read_log
from synchronisation.log_contents import read_contents
from synchronisation.log_mapping import map_log, mapped_neck
from tests.paths import NECK_FILE, SAMPLES
from xneck_foundation.errors import Refused

NECK = read_neck(NECK_FILE)
GEAR = NECK.motors[0].R / NECK.motors[0].rd
ROWS = 1500


def truth() -> Series:
    """Three seconds of motors that all move otherwise, and forces that only pull."""
    time = 12.5 + 0.002 * np.arange(ROWS, dtype=np.float64)
    columns = {}
    for j in range(4):
        columns[f"theta{j + 1}"] = 40.0 * np.sin((1.0 + 0.3 * j) * time + j)
        columns[f"f{j + 1}"] = 40.0 + 20.0 * np.sin((2.0 + 0.5 * j) * time)
    return Series(time, columns)


Column = tuple[str, np.ndarray]


def table(path: Path, columns: list[Column], separator: str = ",", decimal: str = ".") -> Path:
    rows = [separator.join(name for name, _ in columns)]
    for row in np.column_stack([values for _, values in columns]):
        rows.append(separator.join(f"{value:.10g}".replace(".", decimal) for value in row))
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def columns_of(
    series: Series, theta: str, f: str, theta_by: float, f_by: float, time: str, time_by: float
) -> list[Column]:
    """Columns as another logger would have them; the motors' order in the file is not theirs."""
    found: list[Column] = [("row", np.arange(len(series)) * 1.0), (time, series.time * time_by)]
    for j in (2, 0, 3, 1):
        found.append((theta.format(j + 1), series.columns[f"theta{j + 1}"] * theta_by))
        found.append((f"vel{j + 1}", np.gradient(series.columns[f"theta{j + 1}"], 0.002)))
    return [*found, *((f.format(j + 1), series.columns[f"f{j + 1}"] * f_by) for j in (2, 0, 3, 1))]


DEGREES, COUNTS = 180 / np.pi, NECK.motors[0].counts / (2 * np.pi)
OTHERS = {
    "degrees and torques": (("pos_{}_deg", "tau_{}_Nm", DEGREES, 1 / GEAR, "t [ms]", 1e3), ",", "."),
    "milli newton metres": (
        ("motor{}Position [rad]", "motor{}Torque [mNm]", 1.0, 1e3 / GEAR, "timestamp_us", 1e6),
        "\t",
        ".",
    ),
    "european": (("Winkel {} (°)", "Kraft {} [N]", DEGREES, 1.0, "Zeit [s]", 1.0), ";", ","),
    "turns": (("q{}.turns", "force.cmd.{}[mN]", 1 / (2 * np.pi), 1e3, "time", 1e9), ",", "."),
    "negative forces": (("theta{}", "f{}", 1.0, -1.0, "t", 1.0), ",", "."),
}


@pytest.mark.parametrize("case", OTHERS)
def test_what_the_mapping_says_makes_the_log_what_it_was(case: str, tmp_path: Path) -> None:
    """Independent of the reader: columns are converted by hand, found by the survey, and read back by neck.yaml's keys alone."""
    how, separator, decimal = OTHERS[case]
    series = truth()
    log = table(tmp_path / "log.csv", columns_of(series, *how), separator, decimal)
    mapping = map_log(log, read_contents(log), NECK.M)
    assert mapping.rate == pytest.approx(500, rel=1e-6)
    found = read_log(log, mapped_neck(NECK, mapping))
    np.testing.assert_allclose(found.time, series.time, rtol=1e-8)
    np.testing.assert_allclose(found.matrix("theta"), series.matrix("theta"), rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(found.matrix("f"), series.matrix("f"), rtol=1e-5, atol=1e-4)


def test_counts_are_known_by_their_values(tmp_path: Path) -> None:
    series = truth()
    rounded = [(n, np.rint(v) if n.startswith("enc") else v) for n, v in
               columns_of(series, "enc{}", "f{}", COUNTS, 1.0, "time", 1.0)]  # fmt: skip
    log = table(tmp_path / "log.csv", rounded)
    mapping = map_log(log, read_contents(log), None)
    assert [(a.name, a.unit, a.unit_by) for a in mapping.angles] == [
        (f"enc{j}", "counts", "values") for j in (1, 2, 3, 4)
    ]
    found = read_log(log, mapped_neck(NECK, mapping))
    np.testing.assert_allclose(found.matrix("theta"), series.matrix("theta"), atol=0.51 / COUNTS)


def test_what_nothing_tells_is_said_and_not_guessed(tmp_path: Path) -> None:
    """Radians and degrees look alike without a name, and so does the sense of an angle."""
    log = table(tmp_path / "log.csv", columns_of(truth(), "pos{}", "u{}", DEGREES, 1.0, "t", 1.0))
    mapping = map_log(log, read_contents(log), NECK.M)
    assert {a.unit for a in mapping.angles} == {None}
    said = " ".join(mapping.doubts)
    assert "angles' unit" in said
    assert "angles' sense" in said
    assert "forces' unit" in said


def test_measured_angles_and_commanded_forces_are_taken(tmp_path: Path) -> None:
    series = truth()
    columns: list[Column] = [("time", series.time)]
    for j in range(4):
        columns += [(f"pos_cmd{j + 1}", 0 * series.time), (f"pos_act{j + 1}", series.columns[f"theta{j + 1}"])]
        columns += [(f"force_meas{j + 1}", 0 * series.time), (f"force_cmd{j + 1}", series.columns[f"f{j + 1}"])]
    log = table(tmp_path / "log.csv", columns)
    mapping = map_log(log, read_contents(log), 4)
    assert [a.name for a in mapping.angles] == [f"pos_act{j}" for j in (1, 2, 3, 4)]
    assert [f.name for f in mapping.forces] == [f"force_cmd{j}" for j in (1, 2, 3, 4)]


@pytest.mark.parametrize(
    ("angles", "forces", "order"),
    [
        ("BADC", "CADB", "ABCD"),  # letters are an order, as numbers are
        (("left", "right", "upper", "lower"), ("upper", "right", "left", "lower"), ("left", "right", "upper", "lower")),
    ],
)
def test_each_motors_force_is_beside_its_angle(
    angles: Sequence[str], forces: Sequence[str], order: Sequence[str], tmp_path: Path
) -> None:
    """Columns without numbers were taken in the file's order: one motor's angle beside another one's force."""
    series = truth()
    theta = {name: series.columns[f"theta{j + 1}"] for j, name in enumerate(order)}
    f = {name: series.columns[f"f{j + 1}"] for j, name in enumerate(order)}
    columns = [("t", series.time), *((f"q_{name} [rad]", theta[name]) for name in angles)]
    log = table(tmp_path / "log.csv", [*columns, *((f"F_{name} [N]", f[name]) for name in forces)])
    mapping = map_log(log, read_contents(log), 4)
    assert [column.name for column in mapping.angles] == [f"q_{name} [rad]" for name in order]
    assert [column.name for column in mapping.forces] == [f"F_{name} [N]" for name in order]
    assert any(doubt.startswith("which motor is which") for doubt in mapping.doubts)


def test_decimals_that_are_parted_as_cells_are_is_what_is_wrong(tmp_path: Path) -> None:
    """It was said to lack rows, and to be half-written."""
    log = table(tmp_path / "log.csv", [("time", truth().time), *truth().columns.items()], ",", ",")
    for read in (lambda: read_log(log, NECK), lambda: read_contents(log)):
        with pytest.raises(Refused, match=r"row 2 has 1\d cells, the header 9; are its decimals written with commas"):
            read()


def test_pauses_are_found(tmp_path: Path) -> None:
    series = truth()
    late = np.where(np.arange(ROWS) < 500, 0.0, 3.0)
    log = table(
        tmp_path / "log.csv", columns_of(Series(series.time + late, series.columns), "theta{}", "f{}", 1, 1, "t", 1)
    )
    mapping = map_log(log, read_contents(log), 4)
    assert mapping.gaps == ((pytest.approx(0.998, abs=1e-6), pytest.approx(3.002, abs=1e-6)),)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is empty"),
        ("1,2,3\n4,5,6\n7,8,9\n", "has no header"),
        ("time,theta1\n", "no two rows"),
        ("a,b\n1,2\n1,2\n1,2\n", "no column grows"),
        ("time,speed1\n1,2\n1.1,3\n1.2,4\n", "no columns look like the angles"),
        ("time,alpha1,alpha2\n1,2,3\n1.1,3,4\n1.2,4,5\n", "it holds joint angles, not the motors' log"),
        ("time,theta1,theta2\n1,2,3\n1.1,3,4\n1.2,4,5\n", "angles of 4 motors; only theta1, theta2"),
    ],
)
def test_what_is_no_log_is_refused(text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(text)
    with pytest.raises(Refused, match=says):
        map_log(tmp_path / "log.csv", read_contents(tmp_path / "log.csv"), 4)


def test_a_row_of_units_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time,theta1\ns,rad\n1,2\n1.1,3\n1.2,4\n")
    assert read_contents(tmp_path / "log.csv").units_row == 2


def test_columns_that_lack_are_answered_with_the_command_that_maps(tmp_path: Path) -> None:
    log = table(tmp_path / "log.csv", columns_of(truth(), "pos{}", "u{}", 1.0, 1.0, "time", 1.0))
    with pytest.raises(Refused, match=r"lacks the columns theta1.*xneck logs log\.csv"):
        read_log(log, NECK)


def with_columns(neck: Neck) -> Neck:
    motors = tuple(
        m.model_copy(update={"theta_column": f"pos{j}", "f_column": f"force{j}", "joint": f"winch{j}"})
        for j, m in enumerate(neck.motors)
    )
    return neck.model_copy(update={"motors": motors})


def bag_of(kind: str, series: Series) -> Callable[[Path], Path]:
    """Writes a ROS bag with the joints in other orders, by rosbags."""

    def write(folder: Path) -> Path:
        import rosbags.rosbag1
        import rosbags.rosbag2
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE)
        header, stamp, state = (
            store.types[f"{name}"]
            for name in ("std_msgs/msg/Header", "builtin_interfaces/msg/Time", "sensor_msgs/msg/JointState")
        )
        path = folder / "log.bag" if kind == "bag" else folder / "bag"
        writer = rosbags.rosbag1.Writer(path) if kind == "bag" else rosbags.rosbag2.Writer(path, version=9)
        with writer:
            connection = writer.add_connection("/joints", state.__msgtype__, typestore=store)
            for k, time in enumerate(series.time):
                order = (3, 1, 0, 2) if k % 3 else (2, 0, 3, 1)
                ns = round(time * 1e9)
                at = stamp(sec=ns // 10**9, nanosec=ns % 10**9)
                more = {"seq": k} if kind == "bag" else {}
                message = state(
                    header=header(stamp=at, frame_id="", **more),
                    name=[f"winch{j}" for j in order],
                    position=np.array([series.columns[f"theta{j + 1}"][k] for j in order]),
                    velocity=np.empty(0),
                    effort=np.array([series.columns[f"f{j + 1}"][k] for j in order]),
                )
                raw = (store.serialize_ros1 if kind == "bag" else store.serialize_cdr)(message, state.__msgtype__)
                writer.write(connection, ns, raw)
        return path if kind == "bag" else next(path.glob("*.db3"))

    return write


@pytest.mark.parametrize("kind", ["bag", "db3"])
def test_ros_bags_of_both_kinds_are_read_as_they_were_written(kind: str, tmp_path: Path) -> None:
    series = truth().part(slice(0, 300))
    path = bag_of(kind, series)(tmp_path)
    found = read_log(path, with_columns(NECK))
    np.testing.assert_allclose(found.time, series.time, atol=1e-9)
    np.testing.assert_array_equal(found.matrix("theta"), series.matrix("theta"))
    np.testing.assert_array_equal(found.matrix("f"), series.matrix("f"))
    mapping = map_log(path, read_contents(path), 4)
    assert [a.name for a in mapping.angles] == [f"winch{j}" for j in range(4)]
    # cut off, or something else, they are refused in one line
    whole = path.read_bytes()
    for damaged in (whole[: len(whole) // 2], b"no bag at all"):
        path.write_bytes(damaged)
        with pytest.raises(Refused):
            read_log(path, with_columns(NECK))


def test_a_bag_is_not_read_through_links_out_of_its_folder(tmp_path: Path) -> None:
    path = bag_of("db3", truth().part(slice(0, 50)))(tmp_path)
    elsewhere = tmp_path / "elsewhere.db3"
    path.rename(elsewhere)
    path.symlink_to(elsewhere)
    with pytest.raises(Refused, match="leads out of the bag's folder"):
        read_log(path, with_columns(NECK))


def test_parquet_is_read_by_its_columns(tmp_path: Path) -> None:
    import pyarrow
    import pyarrow.parquet

    series = truth()
    ns = pyarrow.array(np.rint(series.time * 1e9).astype("int64")).cast(pyarrow.timestamp("ns"))
    columns = {f"pos{j}": series.columns[f"theta{j + 1}"] for j in (2, 0, 3, 1)}
    columns |= {f"force{j}": series.columns[f"f{j + 1}"] for j in range(4)}
    pyarrow.parquet.write_table(pyarrow.table({"time": ns, "note": ["x"] * ROWS, **columns}), tmp_path / "log.parquet")
    found = read_log(tmp_path / "log.parquet", with_columns(NECK))
    np.testing.assert_allclose(found.time, series.time, atol=1e-9)
    np.testing.assert_array_equal(found.matrix("theta"), series.matrix("theta"))
    mapping = map_log(tmp_path / "log.parquet", read_contents(tmp_path / "log.parquet"), 4)
    assert [f.name for f in mapping.forces] == [f"force{j}" for j in range(4)]
    (tmp_path / "log.parquet").write_bytes(b"PAR1 and nothing more")
    with pytest.raises(Refused, match="cannot be read as Parquet"):
        read_log(tmp_path / "log.parquet", with_columns(NECK))


def test_durations_of_a_parquet_are_seconds_and_a_wrong_column_is_the_one_that_is_named(tmp_path: Path) -> None:
    import pyarrow
    import pyarrow.parquet

    series, log = truth(), tmp_path / "log.parquet"
    ms = pyarrow.array(np.rint(series.time * 1e3).astype("int64")).cast(pyarrow.duration("ms"))
    pyarrow.parquet.write_table(pyarrow.table({"time": ms, **series.columns}), log)
    np.testing.assert_allclose(read_log(log, NECK).time, series.time, atol=1e-9)
    words = {**series.columns, "theta3": ["up"] * ROWS}
    pyarrow.parquet.write_table(pyarrow.table({"time": series.time, **words}), log)
    with pytest.raises(Refused, match="column 'theta3' cannot be read as numbers"):
        read_log(log, NECK)
    twice = [("time", series.time), *series.columns.items(), ("theta1", series.time)]
    pyarrow.parquet.write_table(pyarrow.table([v for _, v in twice], names=[n for n, _ in twice]), log)
    with pytest.raises(Refused, match="has the column 'theta1' 2 times"):
        read_log(log, NECK)


@pytest.mark.parametrize(
    ("begins", "kind", "do"),
    [
        (b"\x1f\x8b\x08", "packed by gzip", "unpack it"),
        (b"PAR1", "a Parquet file", r"let its name end in \.parquet"),
        (b"\x89MCAP0\r\n", "an MCAP file", r"let its name end in \.mcap"),
        (b"#ROSBAG V2.0\n", "a ROS bag", r"let its name end in \.bag"),
        (b"ARROW1\0\0", "an Arrow", "export it as CSV"),
        (b"PK\x03\x04", r"a ZIP archive, as \.xlsx", "export it as CSV"),
        ("time,theta1\n".encode("utf-16"), "text in UTF-16", "save it as UTF-8"),
        ("time,theta1\n0.002,1.5\n0.004,1.6\n".encode("utf-16-le"), "text in UTF-16", "save it as UTF-8"),
        ("time,theta1\n0.002,1.5\n0.004,1.6\n".encode("utf-16-be"), "text in UTF-16", "save it as UTF-8"),
    ],
)
def test_a_file_of_another_kind_that_is_called_csv_is_named_by_its_true_kind(
    begins: bytes, kind: str, do: str, tmp_path: Path
) -> None:
    log = tmp_path / "log.csv"
    log.write_bytes(begins + bytes(range(256)))
    for read in (lambda: read_log(log, NECK), lambda: read_contents(log)):
        with pytest.raises(Refused, match=rf"is no CSV but {kind}.*; {do}"):
            read()


def test_capitals_of_a_suffix_do_not_matter(tmp_path: Path) -> None:
    import shutil

    series = truth()
    of_csv = table(tmp_path / "LOG.CSV", [("time", series.time), *series.columns.items()])
    shutil.copy(SAMPLES / "held_out/log.mcap", tmp_path / "LOG.MCAP")
    for log in (of_csv, tmp_path / "LOG.MCAP"):
        contents = read_contents(log)
        assert len(read_log(log, NECK)) == len(contents.columns.get("time", ())) or contents.topics


@pytest.mark.parametrize(
    ("name", "library", "extra"),
    [("log.bag", "rosbags", "bags"), ("log.db3", "rosbags", "bags"), ("log.parquet", "pyarrow", "parquet")],
)
def test_a_library_that_is_missing_is_named_with_its_extra(
    name: str, library: str, extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / name).write_bytes(b"anything")
    for module in [m for m in sys.modules if m.partition(".")[0] == library]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(Refused, match=rf"needs the library {library}; pip install 'xneck\[{extra}\]'"):
        read_log(tmp_path / name, NECK)


@pytest.mark.parametrize(
    ("name", "kind", "unit"),
    [
        ("t [ms]", "time", "ms"),
        ("Motor 3 position (rev)", "angle", "turns"),
        ("joint_2_torque[N·m]", "force", "N m"),
        ("motorCurrent1", "current", None),
        ("omega_1", "speed", None),
        ("Motorwinkel_1 [Grad]", "angle", "deg"),
        ("Seilkraft2", "force", None),
        ("winch_a_force", "force", None),
        ("winch_a_f", "force", None),
        ("force_2_A", "force", "A"),
        ("Messzeit [s]", "time", "s"),
        ("Auskraftung", "other", None),
        ("led", "light", None),
    ],
)
def test_names_say_what_they_mean(name: str, kind: str, unit: str | None) -> None:
    found = column_meaning(name, np.array([0.1, 0.7, 0.4]))
    assert (found.kind, found.unit) == (kind, unit)
