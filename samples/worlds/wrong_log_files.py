"""Logs and angles that are written in another way than is usual: headers, topics, rates, and angles in other units."""

import numpy as np

from samples.worlds.changed_recordings import (
    angles_changed,
    angles_scaled,
    as_topics,
    faultless,
    log_changed,
    renamed,
    small_in_degrees,
    text_changed,
    with_unit_row,
)
from samples.worlds.wrong_log import WrongLog

MOTORS = ("motor1", "motor2", "motor3", "motor4")
DEG = np.degrees(1)


def _repeated(column: np.ndarray, times: int) -> np.ndarray:
    """Every so many rows hold the first one of them."""
    rows = np.arange(len(column))
    return column[rows - rows % times]


WRONG_FILES: tuple[WrongLog, ...] = (
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
        "a topic for each motor",
        as_topics(*((f"/m{j}", (motor,), 1.0) for j, motor in enumerate(MOTORS))),
        "refused",
        "spread over several topics.*one topic, or write a CSV",
    ),
    WrongLog(
        "topics",
        "the same, and neck.yaml names their topics",
        as_topics(
            *((f"/m{j}", (motor,), 1.0) for j, motor in enumerate(MOTORS)),
            joints=tuple(f"/m{j}/{motor}" for j, motor in enumerate(MOTORS)),
        ),
        "refused",
        "spread over several topics.*one topic, or write a CSV",
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
    *(
        WrongLog(
            "rate",
            f"each sample {times} times",
            log_changed(
                lambda log, times=times: {k: v if k == "time" else _repeated(v, times) for k, v in log.items()}
            ),
            "warned",
            "rows of the log repeat the one before.*a row when the drive has a new sample",
        )
        for times in (2, 5)
    ),
    WrongLog(
        "rate",
        "of 7 s of the 30 s that the camera saw",
        log_changed(lambda log: {name: column[6000:9500] for name, column in log.items()}),
        "accepted",
    ),
    *(WrongLog("rate", f"{hz} Hz", (lambda hz=hz: faultless(hz)), "accepted") for hz in (50.0, 100.0, 1000.0)),
    *(
        WrongLog("camera", f"{hz} frames a second", (lambda hz=hz: faultless(500.0, hz)), "accepted")
        for hz in (5.0, 15.0, 240.0)
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
"""of the log as a file, its rate, and the camera's angles"""
