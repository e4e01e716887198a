"""Logs whose numbers mean something else than their columns say: other units and signs, counters that wrap, slip or stand still."""

import numpy as np

from samples.worlds.changed_recordings import (
    COUNTS,
    changed_after,
    columns_changed,
    faultless,
    held,
    in_bursts,
    in_hundredths,
    log_changed,
    motors_saying,
    renamed,
    scaled,
    since_1970,
    time_changed,
    with_sample,
    without_rows,
)
from samples.worlds.wrong_log import WrongLog

DEG, TURN, COUNT = np.degrees(1), 1 / (2 * np.pi), COUNTS / (2 * np.pi)
R, RD = 25.0, 0.010

WRONG_VALUES: tuple[WrongLog, ...] = (
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
    WrongLog(
        "theta", "of motor 1 10 % too large", scaled("theta", 1.1, 1), "warned", "1.1 counts.*theta_scale.*drum_radius"
    ),
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
        "motors",
        "in reverse order",
        renamed({f"{stem}{j}": f"{stem}{5 - j}" for stem in ("theta", "f") for j in range(1, 5)}),
        "refused",
        "swapped; and|another order: theta4 is motor 1's",
    ),
    WrongLog(
        "theta",
        "columns 2, 3, 1, 4",
        renamed({"theta1": "theta2", "theta2": "theta3", "theta3": "theta1"}),
        "refused",
        "theta2 is motor 1's, theta3 is motor 2's, theta1 is motor 3's",
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
        "not a number in row 7002",
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
)
"""of the time, the motors' angles, and their forces"""
