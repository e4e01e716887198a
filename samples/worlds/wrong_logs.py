"""Logs and angles that mean something else than their columns say, or that are unusual: for tests, and for docs/logs.md.

Each is made from one recording without fault by one change.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mechanism.description import read_neck
from samples.worlds.changed_recordings import (
    COUNTS,
    Recording,
    angles_changed,
    angles_scaled,
    as_topics,
    changed_after,
    columns_changed,
    faultless,
    files_of,
    held,
    in_bursts,
    in_hundredths,
    log_changed,
    motors_saying,
    renamed,
    scaled,
    since_1970,
    small_in_degrees,
    text_changed,
    time_changed,
    with_sample,
    with_unit_row,
    without_rows,
)
from synchronisation.angles import read_angles
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import collected_recoveries


@dataclass(frozen=True)
class WrongLog:
    """One change to a recording, what it is in words, and how it must end."""

    kind: str
    what: str
    make: Callable[[], Recording]
    ends: str
    """`accepted`, `warned` or `refused`"""
    words: str = ""
    """a regular expression that the sentence must match, with what is to be written"""


MOTORS = ("motor1", "motor2", "motor3", "motor4")
DEG, TURN, COUNT = np.degrees(1), 1 / (2 * np.pi), COUNTS / (2 * np.pi)
R, RD = 25.0, 0.010

WRONG_LOGS: tuple[WrongLog, ...] = (
    WrongLog("time", "in milliseconds", time_changed(lambda t: 1e3 * t), "refused", r"milliseconds.*0\.001"),
    WrongLog("time", "in microseconds", time_changed(lambda t: 1e6 * t), "refused", r"microseconds.*1e-06"),
    WrongLog("time", "in nanoseconds", time_changed(lambda t: 1e9 * t), "refused", r"nanoseconds.*1e-09"),
    WrongLog("time", "in seconds since 1970", since_1970, "accepted"),
    WrongLog(
        "time",
        "in milliseconds since 1970",
        time_changed(lambda t: 1e3 * t + 1.7e12),
        "refused",
        r"milliseconds.*0\.001",
    ),
    WrongLog(
        "time", "a number of each row", time_changed(lambda t: np.arange(len(t), dtype=np.float64)), "refused", "rows"
    ),
    WrongLog(
        "time",
        "rounded to hundredths of a second",
        time_changed(in_hundredths),
        "refused",
        "digits",
    ),
    WrongLog("time", "stamped when received, ten rows at once", time_changed(in_bursts), "refused", "bursts"),
    WrongLog("theta", "in degrees", scaled("theta", DEG), "refused", r"degrees.*motors\[\]\.theta_scale: 0\.0174533"),
    WrongLog("theta", "in turns", scaled("theta", TURN), "refused", r"turns.*motors\[\]\.theta_scale: 6\.28319"),
    WrongLog("theta", "in counts", scaled("theta", COUNT), "refused", r"counts.*motors\[\]\.theta_scale: 0\.00306796"),
    WrongLog("theta", "on the gear's other side", scaled("theta", 1 / R), "refused", r"drum.*theta_scale: 25"),
    WrongLog(
        "theta",
        "degrees of the drum",
        scaled("theta", DEG / R),
        "refused",
        r"degrees of the drum.*theta_scale: 0\.436332",
    ),
    WrongLog("theta", "metres of cable", scaled("theta", RD / R), "refused", r"cable.*theta_scale: 2500"),
    WrongLog(
        "theta", "millimetres of cable", scaled("theta", 1e3 * RD / R), "refused", r"mm of cable.*theta_scale: 2\.5"
    ),
    WrongLog(
        "theta", "of motor 3 in degrees", scaled("theta", DEG, 3), "refused", r"motors\[2\]\.theta_scale: 0\.0174533"
    ),
    WrongLog(
        "theta", "of motor 2 in counts", scaled("theta", COUNT, 2), "refused", r"motors\[1\]\.theta_scale: 0\.00306796"
    ),
    WrongLog(
        "theta",
        "of motor 2 3.2 times too small",
        scaled("theta", 1 / 3.2, 2),
        "refused",
        r"log: theta2 would move its cable 0\.3\d* times as far",
    ),
    WrongLog("theta", "of motor 1 10 % too large", scaled("theta", 1.1, 1), "accepted", "drum_radius"),
    WrongLog(
        "theta",
        "in rad, and theta_scale says degrees",
        motors_saying(faultless, theta_scale=float(np.radians(1.0))),
        "refused",
        r"motors\[\]\.theta_scale: 1\b",
    ),
    WrongLog("theta", "of motor 2 reversed", scaled("theta", -1, 2), "refused", r"theta2 runs against.*theta_sign"),
    WrongLog("theta", "all reversed", scaled("theta", -1), "refused", "all theta run against.*theta_sign"),
    WrongLog(
        "theta", "all reversed and in degrees", scaled("theta", -DEG), "refused", r"theta_scale: 0\.0174533|theta_sign"
    ),
    WrongLog(
        "theta",
        "of motors 2 and 3 exchanged",
        renamed({"theta2": "theta3", "theta3": "theta2"}),
        "refused",
        "theta2 and theta3 are swapped",
    ),
    WrongLog(
        "theta",
        "columns 2, 3, 1, 4",
        renamed({"theta1": "theta2", "theta2": "theta3", "theta3": "theta1"}),
        "refused",
        "order 2, 3, 1, 4|order 3, 1, 2, 4",
    ),
    WrongLog("f", "reversed", scaled("f", -1), "refused", r"motors\[\]\.f_scale: -1"),
    WrongLog("f", "of motor 2 reversed", scaled("f", -1, 2), "refused", r"motors\[1\]\.f_scale: -1"),
    WrongLog("f", "in millinewtons", scaled("f", 1e3), "refused", r"motors\[\]\.f_scale: 0\.001"),
    WrongLog("f", "in kilonewtons", scaled("f", 1e-3), "refused", r"motors\[\]\.f_scale: 1000"),
    WrongLog("f", "the motor's torque", scaled("f", RD / R), "refused", r"motors\[\]\.f_scale: 2500"),
    WrongLog("f", "the drum's torque", scaled("f", RD), "refused", r"motors\[\]\.f_scale: 100"),
    WrongLog("f", "the torque of motor 3 alone", scaled("f", RD / R, 3), "refused", r"motors\[2\]\.f_scale: 2500"),
    WrongLog("f", "zero", scaled("f", 0), "refused", "f1, f2, f3, f4"),
    WrongLog("f", "of motor 4 zero", scaled("f", 0, 4), "refused", "f4"),
    WrongLog("f", "constant", columns_changed("f", lambda f: np.full_like(f, 30.0)), "refused", "f1, f2, f3, f4"),
    WrongLog(
        "f", "of motor 4 constant", columns_changed("f", lambda f: np.full_like(f, 30.0), 4), "warned", "f4 stays at 30"
    ),
    WrongLog(
        "f",
        "of motor 2 missing",
        log_changed(lambda log: {k: v for k, v in log.items() if k != "f2"}),
        "refused",
        "lacks the column f2",
    ),
    WrongLog(
        "f", "not logged", log_changed(lambda log: {k: v for k, v in log.items() if k[0] != "f"}), "warned", "no forces"
    ),
    WrongLog(
        "counter",
        "of 16 bits that wraps",
        motors_saying(
            columns_changed("theta", lambda th: (np.rint(th * COUNT) * 16 + 32768) % 65536 - 32768),
            theta_scale=float(2 * np.pi / COUNTS / 16),
        ),
        "warned",
        "wrap",
    ),
    WrongLog("counter", "wraps at 0 and 2 pi", columns_changed("theta", lambda th: th % (2 * np.pi)), "warned", "wrap"),
    WrongLog(
        "counter",
        "wraps at -pi and pi",
        columns_changed("theta", lambda th: (th + np.pi) % (2 * np.pi) - np.pi),
        "warned",
        "wrap",
    ),
    WrongLog(
        "counter",
        "theta2 one sample of 1e6",
        columns_changed("theta", lambda th: with_sample(th, 7000, 1e6), 2),
        "warned",
        "theta2",
    ),
    WrongLog(
        "counter",
        "theta2 one sample of zero",
        columns_changed("theta", lambda th: with_sample(th, 7003, 0.0), 2),
        "warned",
        "theta2",
    ),
    WrongLog(
        "counter", "f3 one sample of 1e5", columns_changed("f", lambda f: with_sample(f, 7000, 1e5), 3), "warned", "f3"
    ),
    WrongLog(
        "counter",
        "a row of NaN",
        columns_changed("theta", lambda th: with_sample(th, 7000, np.nan)),
        "refused",
        "not a number in sample 7001",
    ),
    WrongLog(
        "counter", "a gap of 1 s", log_changed(lambda log: without_rows(log, 7000, 7500)), "warned", "gaps of the log"
    ),
    WrongLog(
        "counter",
        "theta2 slips by 2 mm",
        columns_changed("theta", lambda th: changed_after(th, 7000, lambda part: part + 0.002 * R / RD), 2),
        "warned",
        "cable 2",
    ),
    WrongLog(
        "counter",
        "theta2 loses 1 % of its counts",
        columns_changed("theta", lambda th: th + 0.01 * np.cumsum(np.maximum(np.diff(th, prepend=th[:1]), 0)), 2),
        "accepted",
        "missed_counts|drum_radius",
    ),
    WrongLog(
        "counter", "theta3 is stuck", columns_changed("theta", lambda th: np.zeros_like(th), 3), "refused", "theta3"
    ),
    WrongLog(
        "counter",
        "theta3 is stuck for 5 s",
        columns_changed("theta", lambda th: held(th, 6000, 8500), 3),
        "refused",
        "theta3",
    ),
    WrongLog(
        "header",
        "in capitals",
        renamed({f"{s}{j}": f"{s.title()}{j}" for s in ("theta", "f") for j in range(1, 5)} | {"time": "Time"}),
        "refused",
        "Theta1",
    ),
    WrongLog(
        "header",
        "with spaces and units",
        renamed({f"theta{j}": f"theta {j} [rad]" for j in range(1, 5)}),
        "refused",
        "theta 1",
    ),
    WrongLog("header", "columns parted by semicolons", text_changed(lambda t: t, ";"), "refused", "semicolon"),
    WrongLog("header", "columns parted by tabs", text_changed(lambda t: t, "\t"), "refused", "tab"),
    WrongLog(
        "header",
        "semicolons and decimal commas",
        text_changed(lambda t: t.replace(".", ","), ";"),
        "refused",
        "semicolon.*comma",
    ),
    WrongLog("header", "a row of units below it", text_changed(with_unit_row), "refused", "row 2.*unit"),
    WrongLog("header", "missing", text_changed(lambda t: t.split("\n", 1)[1]), "refused", "no header|header"),
    WrongLog(
        "header",
        "further columns",
        log_changed(lambda log: log | {"current1": log["f1"], "state": log["f2"]}),
        "accepted",
    ),
    WrongLog("header", "columns in another order", log_changed(lambda log: dict(reversed(log.items()))), "accepted"),
    WrongLog(
        "header",
        "theta4 missing",
        log_changed(lambda log: {k: v for k, v in log.items() if k != "theta4"}),
        "refused",
        "lacks the column theta4",
    ),
    WrongLog(
        "header",
        "of five motors",
        log_changed(lambda log: log | {"theta5": log["theta1"], "f5": log["f1"]}),
        "refused",
        "theta5",
    ),
    WrongLog(
        "topics",
        "measured and commanded",
        as_topics(("/joint_states", MOTORS, 1.0), ("/joint_command", MOTORS, 1.01)),
        "refused",
        r"joint_command.*motors\[0\]\.joint: /joint_states/motor1",
    ),
    WrongLog(
        "topics",
        "the same, and neck.yaml says which",
        as_topics(
            ("/joint_states", MOTORS, 1.0),
            ("/joint_command", MOTORS, 1.01),
            joints=tuple(f"/joint_states/{m}" for m in MOTORS),
        ),
        "accepted",
    ),
    WrongLog(
        "topics",
        "a gripper among the motors",
        as_topics(("/joint_states", ("gripper", *MOTORS), 1.0)),
        "refused",
        r"gripper.*motors\[\]\.joint",
    ),
    WrongLog(
        "topics",
        "the same, and neck.yaml names the motors",
        as_topics(("/joint_states", ("gripper", *MOTORS), 1.0), joints=MOTORS),
        "accepted",
    ),
    *(
        WrongLog(
            "rate",
            f"{500 // every} Hz, one row of {every} kept",
            (lambda every=every: faultless(every=every)),
            ends,
            words,
        )
        for every, ends, words in (
            (50, "refused", "10 rows.*at least 50"),
            (25, "refused", "20 rows.*at least 50"),
            (10, "warned", "one row of several"),
            (5, "warned", "one row of several"),
        )
    ),
    *(WrongLog("rate", f"{hz} Hz", (lambda hz=hz: faultless(hz)), "accepted") for hz in (50.0, 100.0, 200.0, 1000.0)),
    *(
        WrongLog("camera", f"{hz} frames a second", (lambda hz=hz: faultless(500.0, hz)), "accepted")
        for hz in (5.0, 10.0, 15.0, 60.0, 120.0, 240.0)
    ),
    WrongLog("angles", "in degrees", angles_scaled("alpha", DEG), "refused", "degrees.*0.0174533"),
    WrongLog("angles", "in degrees, of a motion by less than 3", small_in_degrees, "refused", "degrees.*0.0174533"),
    WrongLog("angles", "time in milliseconds", angles_scaled("time", 1e3), "refused", r"milliseconds.*0\.001"),
    WrongLog(
        "angles", "time in frames", angles_changed(lambda a: a | {"time": np.rint(a["time"] * 30)}), "refused", "frames"
    ),
    WrongLog(
        "angles",
        "of two joints",
        angles_changed(lambda a: {k: v for k, v in a.items() if k[-1] != "3"}),
        "refused",
        "alpha3",
    ),
    WrongLog("angles", "of four joints", angles_changed(lambda a: a | {"alpha4": a["alpha1"]}), "refused", "alpha4"),
    WrongLog("angles", "mirrored", angles_scaled("alpha", -1), "refused", "all theta run against.*mirrored"),
    WrongLog("angles", "sigma in degrees", angles_scaled("sigma", DEG), "refused", "sigma.*degrees.*0.0174533"),
    WrongLog("angles", "sigma 20 times too large", angles_scaled("sigma", 20), "warned", "sigma"),
)
"""every one of them, in the order of docs/logs.md"""


@dataclass(frozen=True)
class Outcome:
    """How a recording went through `sync`."""

    ends: str
    """`accepted`, `warned` or `refused`"""
    sentence: str
    """what the user is told"""
    clock_error_s: float | None = None
    """in the middle of the video"""
    clock_sigma_s: float = 0.0


def outcome_of(wrong: WrongLog, folder: Path) -> Outcome:
    """Writes the files into a folder and synchronises them as `xneck sync` does."""
    recording = wrong.make()
    neck_file, angles_file, log_file = files_of(recording, folder)
    try:
        with collected_recoveries() as recovered:
            neck = read_neck(neck_file)
            log, angles = read_log(log_file, neck), read_angles(angles_file, neck.N)
            data = synchronise(neck, neck_file.read_text(encoding="utf-8"), angles, log, {})
    except Refused as refusal:
        return Outcome("refused", str(refusal).replace(f"{folder}/", ""))
    clock = data.clock
    middle = (angles.time[0] + angles.time[-1]) / 2
    offset = clock["offset_s"] + 1e-6 * clock["skew_ppm"] * (middle - clock["camera_middle_s"])
    warnings = [text.replace(f"{folder}/", "") for text in (*recovered, *clock["warnings"])]
    fault = data.check["faults"][0] if data.check["faults"] else None
    named = f"`check`: {data.check['verdict']}" + (f", {fault['fault']} of {fault['where']}" if fault else "")
    return Outcome(
        "warned" if warnings else "accepted",
        "; ".join([*warnings, named]),
        clock_error_s=offset - recording.offset_s,
        clock_sigma_s=clock["offset_sigma_s"],
    )
