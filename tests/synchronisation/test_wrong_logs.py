"""Logs and angles that mean something else than their columns say: each comes out right, or is refused with what is true of it."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from identification.dataset.series import Series, numbered_columns
from identification.dataset.time_unit import check_repeated_rows, check_time_unit
from mechanism.arm import arm_of
from mechanism.description import read_neck
from samples.generator.laws import dry_and_viscous, linear
from samples.generator.prescribed import World, prescribe
from samples.worlds.changed_recordings import COUNTS, faultless, files_of
from samples.worlds.clock_worlds import NOISE_RAD
from samples.worlds.wrong_log import WrongLog, outcome_of
from samples.worlds.wrong_logs import WRONG_LOGS
from synchronisation.angles import Angles, read_angles
from synchronisation.csv_table import read_table
from synchronisation.encoder_log import read_log, uniformly_sampled
from synchronisation.log_contents import read_contents
from synchronisation.log_mapping import map_log
from synchronisation.log_plausibility import check_log_meaning
from synchronisation.log_units import theta_units, unit_of
from synchronisation.long.recording_parts import even_rows
from tests.paths import SAMPLES
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import collected_recoveries

READ = ("time", "header", "topics", "rate")
"""kinds that are refused when they are read"""
MAX_CLOCK_SIGMAS = 4.0


def named(wrong: WrongLog) -> str:
    return f"{wrong.kind} {wrong.what}"


def cases() -> list[object]:
    others = [w for w in WRONG_LOGS if not w.is_only_written_otherwise]
    quick = [w.kind in READ and w.ends == "refused" for w in others]
    return [
        pytest.param(w, id=named(w), marks=() if fast else pytest.mark.slow)
        for w, fast in zip(others, quick, strict=True)
    ]


@pytest.mark.parametrize("wrong", cases())
def test_a_log_comes_out_right_or_is_refused_with_what_is_true(wrong: WrongLog, tmp_path: Path) -> None:
    outcome = outcome_of(wrong, tmp_path)
    assert outcome.ends == wrong.ends, outcome.sentence
    assert re.search(wrong.words, outcome.sentence), outcome.sentence
    if outcome.clock_error_s is not None:
        assert abs(outcome.clock_error_s) < MAX_CLOCK_SIGMAS * outcome.clock_sigma_s


@pytest.mark.parametrize("wrong", [w for w in WRONG_LOGS if w.is_only_written_otherwise], ids=named)
def test_a_log_that_is_only_written_otherwise_holds_the_same(wrong: WrongLog, tmp_path: Path) -> None:
    """Angles to a tenth of a count, for what counts makes of them."""
    recording = wrong.make()
    neck_file, _, log_file = files_of(recording, tmp_path)
    with collected_recoveries() as recovered:
        log = read_log(log_file, read_neck(neck_file))
    assert re.search(wrong.words, "; ".join(recovered))
    made = faultless()
    later = recording.offset_s - made.offset_s
    np.testing.assert_allclose(log.time - later, made.log["time"], atol=1e-4)
    moved = log.matrix("theta") - log.matrix("theta")[0]
    theta, f = (np.column_stack([made.log[f"{stem}{j}"] for j in range(1, 5)]) for stem in ("theta", "f"))
    np.testing.assert_allclose(moved, theta - theta[0], atol=0.1 * 2 * np.pi / COUNTS)
    np.testing.assert_allclose(log.matrix("f"), f, atol=1e-6)


def test_what_is_to_be_written_makes_the_log_right(tmp_path: Path) -> None:
    """Degrees of the motor and its torque, once with the keys that the refusals name."""
    recording = faultless()
    log = {k: np.degrees(v) if k[0] == "t" and k != "time" else v for k, v in recording.log.items()}
    log |= {f"f{j}": recording.log[f"f{j}"] / 2500 for j in range(1, 5)}
    neck = dict(recording.neck)
    neck["motors"] = [{**motor, "theta_scale": 0.0174533, "f_scale": 2500.0} for motor in neck["motors"]]
    neck_file, _, _ = files_of(recording, tmp_path)
    plain = read_neck(neck_file)
    as_logged = Series(log["time"], {k: v for k, v in log.items() if k != "time"})
    angles = read_angles(tmp_path / "angles.csv", 3)
    with pytest.raises(Refused, match=r"degrees.*motors\[\]\.theta_scale: 0\.0174533"):
        check_log_meaning(plain, arm_of(plain), angles, as_logged)
    in_radians = Series(
        log["time"], {k: np.radians(v) if k.startswith("theta") else v for k, v in as_logged.columns.items()}
    )
    with pytest.raises(Refused, match=r"N m of the motor.*motors\[\]\.f_scale: 2500"):
        check_log_meaning(plain, arm_of(plain), angles, in_radians)
    right = type(recording)(neck, recording.angles, log, recording.offset_s)
    (tmp_path / "right").mkdir()
    neck_file, _, log_file = files_of(right, tmp_path / "right")
    mapped = read_neck(neck_file)
    assert check_log_meaning(mapped, arm_of(mapped), angles, read_log(log_file, mapped)) == ()
    # gears of 20 in place of the example's 25, with as much travel, and f_scale left as it was
    geared = [m.model_copy(update={"R": 20.0, "theta_scale": 0.8 * m.theta_scale}) for m in mapped.motors]
    stale = mapped.model_copy(update={"motors": tuple(geared)})
    (warning,) = check_log_meaning(stale, arm_of(stale), angles, read_log(log_file, stale))
    assert re.search(r"f_scale of 4 motors is 2500.*R / rd = 2000: if f is the motor's torque, write that", warning)


def test_a_factor_is_no_unit_where_it_is_not_one_of_them() -> None:
    """3.2 lies between millimetres of cable, 2.5, and turns, 6.3."""
    motor = read_neck(SAMPLES / "recording/neck.yaml").motors[0]
    assert unit_of(3.2, theta_units(motor), 0.2) is None
    named = unit_of(np.pi / 180 * 0.95, theta_units(motor), 0.2)
    assert named is not None
    assert named.name == "degrees"


@pytest.mark.parametrize(("newtons", "says"), [(2500 / 1.02, "f is in N m of"), (2500 / 1.25, "f may be in N m of")])
def test_a_unit_is_said_to_be_it_only_where_the_factor_is_its_own(newtons: float, says: str, tmp_path: Path) -> None:
    """A motor's current is in no unit that is known; where N m of the motor come near, its own factor is said beside."""
    recording = faultless()
    log = {k: v / newtons if k[0] == "f" else v for k, v in recording.log.items()}
    neck_file, _, _ = files_of(recording, tmp_path)
    neck = read_neck(neck_file)
    as_logged = Series(log["time"], {k: v for k, v in log.items() if k != "time"})
    with pytest.raises(Refused, match=says) as refused:
        check_log_meaning(neck, arm_of(neck), read_angles(tmp_path / "angles.csv", 3), as_logged)
    its_own = re.search(r"else motors\[\]\.f_scale .* comes to about (.*)$", str(refused.value))
    assert (its_own is None) == (newtons > 2400)
    assert its_own is None or float(its_own[1]) == pytest.approx(newtons, rel=0.1)


UNLIKE_DRUMS_M = np.array([0.010, 0.0118, 0.0119, 0.0108])
MILLI = 1e3 * UNLIKE_DRUMS_M / 15.0


def forces_scaled(by: np.ndarray, folder: Path) -> tuple[str, ...]:
    """What is said of forces that are logged so many times as large: of motors with gears of 15 and unlike drums."""
    recording = faultless()
    log, motors = dict(recording.log), []
    for j, (motor, rd) in enumerate(zip(recording.neck["motors"], UNLIKE_DRUMS_M, strict=True)):
        # turns as many times as far for the same motion of its cable, with an inertia that is felt on it as before
        turns = (motor["rd"] / motor["R"]) / (rd / 15.0)
        motors.append({**motor, "R": 15.0, "rd": float(rd), "Ia": float(motor["Ia"] / turns**2)})
        log[f"theta{j + 1}"] = log[f"theta{j + 1}"] * turns
        log[f"f{j + 1}"] = log[f"f{j + 1}"] * by[j]
    changed = type(recording)({**recording.neck, "motors": motors}, recording.angles, log, recording.offset_s)
    neck_file, angles_file, log_file = files_of(changed, folder)
    neck = read_neck(neck_file)
    return check_log_meaning(neck, arm_of(neck), read_angles(angles_file, 3), read_log(log_file, neck))


def test_torques_near_newtons_are_known_by_the_drums_of_all_motors(tmp_path: Path) -> None:
    """In mN m of the motor the arm needs 1.3 to 1.5 times the logged forces, which each motor alone would not tell."""
    with pytest.raises(Refused, match=r"f is in mN m of the motor") as refused:
        forces_scaled(MILLI, tmp_path)
    told = [float(x) for x in re.findall(r"motors\[\d\]\.f_scale: ([\d.]+)", str(refused.value))]
    np.testing.assert_allclose(told, 1 / MILLI, rtol=1e-5)


def test_a_factor_alike_for_all_motors_is_no_torque_of_unlike_drums(tmp_path: Path) -> None:
    """Tenths of a newton: mN m of the drum would be 83 to 100 of them, another number for each motor."""
    with pytest.raises(Refused, match=r"f_scale, which comes to about 0\.0\d+$") as refused:
        forces_scaled(np.full(4, 10.0), tmp_path)
    assert "drum" not in str(refused.value)


@pytest.mark.parametrize("by", [0.6, 0.75, 1.9])
def test_a_factor_in_common_beyond_what_a_drawing_allows_is_asked_of(by: float, tmp_path: Path) -> None:
    (warning,) = forces_scaled(np.full(4, by), tmp_path)
    assert re.search(r"the arm as described needs .* times the logged forces", warning)


@pytest.mark.parametrize("gains", [(1, 1, 1, 1), (1, 1.1, 1, 1), (1, 1, 0.9, 1)])
def test_the_gain_of_one_motor_is_left_to_the_diagnosis(gains: tuple[float, ...], tmp_path: Path) -> None:
    assert forces_scaled(1 / np.array(gains), tmp_path) == ()


@pytest.mark.parametrize("forces", [True, False])
def test_the_sample_is_not_doubted(forces: bool) -> None:
    folder = SAMPLES / "held_out"
    neck = read_neck(folder / "neck.yaml")
    log, angles = read_log(folder / "log.mcap", neck), read_angles(folder / "angles.csv", neck.N)
    kept = {k: v for k, v in log.columns.items() if forces or k[0] != "f"}
    assert check_log_meaning(neck, arm_of(neck), angles, Series(log.time, kept)) == ()


def arm_of_joints(n: int) -> dict[str, Any]:
    """neck.yaml of n joints and n + 1 cables."""
    neck = dict(faultless().neck)
    cable = {"length": 1.3, "section": 7.9e-7, "x0": 0.004}
    routes = [[*["strut"] * i, "right"] for i in range(n)] + [[*["left_through"] * (n - 1), "left"]]
    neck["mechanisms"] = [neck["mechanisms"][0]] * n
    neck["cables"] = [{"route": route, **cable} for route in routes]
    neck["motors"] = [neck["motors"][0]] * (n + 1)
    del neck["markers"]
    return neck


@pytest.mark.parametrize(("joints", "peak_deg"), [(1, (25.0, 32.0)), (6, (12.0, 18.0))])
def test_arms_of_one_and_of_six_joints_are_not_doubted_but_where_units_are_wrong(
    joints: int, peak_deg: tuple[float, float], tmp_path: Path
) -> None:
    described = arm_of_joints(joints)
    m = joints + 1
    world = World(
        described,
        stretch=linear(np.full(m, 8000.0), np.full(m, 60.0)),
        friction=dry_and_viscous(np.full(m, 15.0), np.zeros(m)),
    )
    p = prescribe(world, 20.0, 3, peak_deg=peak_deg)
    (tmp_path / "neck.yaml").write_text(json.dumps(described))
    neck = read_neck(tmp_path / "neck.yaml")
    noise = np.random.default_rng(0).normal(0, NOISE_RAD, p.frame_alpha.shape)
    angles = Angles(p.frame_times, p.frame_alpha + noise, np.full(noise.shape, NOISE_RAD))

    def check(theta: float, f: float) -> tuple[str, ...]:
        columns = numbered_columns("theta", theta * p.counted) | numbered_columns("f", f * p.f)
        return check_log_meaning(neck, arm_of(neck), angles, Series(p.log_time, columns))

    assert check(1.0, 1.0) == ()
    for theta, f, words in (
        (np.degrees(1), 1.0, "theta is in degrees"),
        (1.0, 1e3, "f is in millinewtons"),
        (1.0, -1.0, "wrong sign"),
    ):
        with pytest.raises(Refused, match=words):
            check(theta, f)


def test_units_of_time_exclude_each_other() -> None:
    """10 to 1000 rows a second in each unit, never another's name, and seconds pass."""
    for hz in (10, 20, 50, 125, 500, 1000):
        seconds = np.cumsum(np.r_[0.0, np.random.default_rng(hz).uniform(0.9, 1.1, 500) / hz])
        check_time_unit(seconds, "log", "rows")
        for name, unit in (("milli", 1e3), ("micro", 1e6), ("nano", 1e9)):
            with pytest.raises(Refused, match=f"time is in {name}seconds"):
                check_time_unit(seconds * unit, "log", "rows")


def test_a_log_in_bursts_is_refused_before_anything_large_is_made() -> None:
    """A step of 1 ns in the median would make 3e10 rows."""
    time = (np.arange(15000) // 10) * 0.02 + 1e-9 * (np.arange(15000) % 10)
    with pytest.raises(Refused, match="bursts"):
        uniformly_sampled(Series(time, {"theta1": time}))


def test_angles_between_late_rows_of_a_slow_log_are_beside_the_chord() -> None:
    """At 100 Hz a motor that turns back in a tenth of a second is off the chord by hundredths of a radian."""
    rng = np.random.default_rng(5)
    time = np.arange(1000) * 0.01 + rng.uniform(-0.002, 0.002, 1000)
    time[[0, -1]] = 0.0, 9.99
    angle, force = (lambda t: np.sin(30 * t)), (lambda t: np.sign(np.sin(9 * t)))
    even = uniformly_sampled(Series(time, {"theta1": angle(time), "f1": force(time)}))
    assert np.abs(np.interp(even.time, time, angle(time)) - angle(even.time)).max() > 0.008
    assert np.abs(even.columns["theta1"] - angle(even.time))[2:-2].max() < 0.001
    # a command that is held has corners, and nothing is told of a gap
    assert np.abs(even.columns["f1"]).max() <= 1.0
    kept = (time < 4.0) | (time > 4.3)
    gap = uniformly_sampled(Series(time[kept], {"theta1": angle(time[kept])}))
    inside = (gap.time > 4.05) & (gap.time < 4.25)
    np.testing.assert_allclose(np.diff(gap.columns["theta1"][inside], 2), 0.0, atol=1e-9)


def test_forces_of_late_rows_are_the_means_of_what_was_held() -> None:
    """What a command gives in all is what it gave on the rows as they were written, and even rows stay what they are."""
    rng = np.random.default_rng(6)
    time = np.arange(2000) * 0.005 + rng.uniform(0.0, 0.004, 2000) * (rng.random(2000) < 0.3)
    time[[0, -1]] = 0.0, 1999 * 0.005
    force = rng.normal(40, 5, 2000)
    even = uniformly_sampled(Series(time, {"theta1": time, "f1": force}))
    step = even.time[1] - even.time[0]
    fine = np.arange(0.0, even.time[-1], 1e-5) + 5e-6  # s, each a moment of what was held
    held = force[np.searchsorted(time, fine, side="right") - 1]
    row = np.minimum((fine / step).astype(int), len(even.time) - 1)
    means = np.bincount(row, held) / np.bincount(row)
    np.testing.assert_allclose(even.columns["f1"][: len(means) - 1], means[:-1], atol=0.1)
    kept = rng.random(2000) < 0.9
    kept[[0, -1]] = True
    even_time = np.asarray(0.005 * np.arange(2000), dtype=float)
    slow = 40 + 5 * np.sin(7 * even_time)
    lost = uniformly_sampled(Series(even_time[kept], {"f1": slow[kept]})).columns["f1"]
    assert np.abs(lost - slow).max() < 0.5  # N, of .175 a row
    assert np.abs(np.mean(lost - slow)) < 0.01
    as_it_is = uniformly_sampled(Series(even_time, {"f1": force}))
    np.testing.assert_allclose(as_it_is.columns["f1"], force, rtol=1e-12)


def test_a_part_of_even_rows_is_that_of_the_whole() -> None:
    rng = np.random.default_rng(7)
    time = np.sort(np.arange(3000) * 0.002 + rng.uniform(0, 0.0015, 3000))
    log = Series(time, {"theta1": np.sin(9 * time), "f1": rng.normal(size=3000), "light": rng.normal(size=3000)})
    whole, rows = uniformly_sampled(log), even_rows(log)
    np.testing.assert_allclose(rows.time, whole.time, rtol=1e-12)
    for begin, end in ((0, 900), (900, 2000), (2000, len(whole.time))):
        part = rows.part(begin, end)
        for name, values in whole.columns.items():
            np.testing.assert_allclose(part.columns[name], values[begin:end], atol=1e-5)


def test_forces_in_capitals_are_not_taken_for_forces_that_are_not_logged(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time,theta1,F1\n0,0,0\n1,1,1\n")
    with pytest.raises(Refused, match="f1 as 'F1'"):
        read_table(tmp_path / "log.csv", ["theta1"], optional=["f1"])


LINES = [f"{100 + 0.002 * k:.6f},{0.01 * k:.6f}" for k in range(3000)]
"""a time and an angle, well but for what a test does to them"""


def read_and_survey(path: Path) -> list[str]:
    """What the two readers of a table say where they refuse it, else what they warn of."""
    said = []
    for read in (lambda: read_table(path, ["theta1"]), lambda: map_log(path, read_contents(path), None)):
        with collected_recoveries() as warned:
            try:
                read()
            except Refused as refusal:
                warned.append(str(refusal))
        said.append("; ".join(warned))
    return said


def test_lines_that_hold_nothing_and_comments_are_passed_over(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    rows = "\n".join([*LINES[:50], "", "# the motors are switched on", *LINES[50:], ",", ""])
    for before in ("\n\n", ",,\n", '# controller v3, a "test\n', "#\n"):
        log.write_text(f"{before}time,theta1\n{rows}")
        np.testing.assert_allclose(read_table(log, ["theta1"]).columns["theta1"], 0.01 * np.arange(3000))
        assert len(read_contents(log).columns["theta1"]) == 3000
    log.write_text("# time,theta1\n" + rows)  # as NumPy's savetxt writes it
    assert "its header spells time as '# time'" in read_and_survey(log)[0]


@pytest.mark.parametrize(
    ("header", "change", "says"),
    [
        ("time theta1", lambda row: row.replace(",", " "), "columns are parted by spaces; write commas"),
        ("time,theta1", lambda row: f"2026-11-02T09:01:40.{row}", r"row 2, column time: .* is a date; write the time in seconds"),
        ("time,theta1", lambda row: f"09:01:{row[1:]}", "row 2, column time: .* is a time of day"),
        ("time,theta1", lambda row: '"' + row.replace(",", '","').replace(".", ",") + '"', "row 2.*has a decimal comma"),
        ("time,theta1", lambda row: f"0x1.9p+6{row[10:]}", "row 2.*is a hexadecimal number"),
    ],
)  # fmt: skip
def test_numbers_and_columns_in_another_way_of_writing_are_named(
    header: str, change: Callable[[str], str], says: str, tmp_path: Path
) -> None:
    (tmp_path / "log.csv").write_text("\n".join([header, *map(change, LINES), ""]))
    for said in read_and_survey(tmp_path / "log.csv"):
        assert re.search(says, said)
        assert "xneck logs" not in said  # which says the same


def test_rows_that_are_written_twice_are_no_lack_of_digits(tmp_path: Path) -> None:
    twice = np.repeat(np.linspace(0, 6, 3000), 2)
    with pytest.raises(Refused, match=r"50 % of its rows repeat the one before.*write each of the rows once"):
        check_repeated_rows(Series(twice, {"theta1": twice}), "log", "rows")
    check_repeated_rows(Series(twice, {"theta1": np.linspace(0, 1, 6000)}), "log", "rows")
    (tmp_path / "log.csv").write_text("\n".join(["time,theta1", *(row for row in LINES for _ in range(2)), ""]))
    mapping = map_log(tmp_path / "log.csv", read_contents(tmp_path / "log.csv"), None)
    assert mapping.rate == pytest.approx(500)
    assert (mapping.gaps, mapping.repeated) == ((), 3000)


def test_rows_are_called_by_their_lines_in_the_file(tmp_path: Path) -> None:
    """Behind a blank line and a comment too, by every check."""
    neck, log = read_neck(SAMPLES / "held_out/neck.yaml"), tmp_path / "log.csv"
    header = ["# of the controller", "", "time,theta1,theta2,theta3,theta4"]
    lines = [f"{row},0,{0.02 * k},1" for k, row in enumerate(LINES)]
    for wrong, says in (
        ("NULL,0,0,0,1", "row 1004, column time"),
        ("nan,0,0,0,1", "time is not finite in row 1004"),
        (f"{LINES[999]},0,9,1", "time stands still in row 1004"),
        (f"{LINES[1000]},nan,0,1", "theta2 is not a number in row 1004"),
        ("1,2", "row 1004 has 2 cells"),
    ):
        log.write_text("\n".join([*header, *lines[:1000], wrong, *lines[1001:], ""]))
        with pytest.raises(Refused, match=says):
            read_log(log, neck)
    assert read_contents(log).odd_rows == (1004,)


def test_a_last_line_that_may_be_cut_in_a_number_is_left_out_and_that_is_said(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("\n".join(["time,theta1", *LINES])[:-5])
    for said in read_and_survey(log):
        assert re.search("row 3001, the last, has no line end: it may be cut", said)
    with collected_recoveries():
        assert read_table(log, ["theta1"]).columns["theta1"][-1] == 29.98
    log.write_text("\r\n".join(["time,theta1", *LINES, ""]))
    assert read_and_survey(log) == ["", ""]
