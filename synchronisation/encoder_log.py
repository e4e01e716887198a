"""The controller's log: motor angles theta and forces f on its own clock, brought into our signs and units."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series, check_size, check_time, numbered_columns
from identification.files import joint_state
from mechanism.description import Neck
from synchronisation.csv_table import read_table
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed

Array = NDArray[np.float64]

LED = "led"
"""column of a log, or joint of an MCAP, that says whether the light was on"""
MAX_LOGGED_MAGNITUDE = 1e9
"""largest motor angle or force that a log may hold, in whatever unit it is logged (docs/thresholds.md)"""

_SHOWN = 60
"""characters of joints' names that are shown"""


def read_log(path: str | Path, neck: Neck) -> Series:
    """Columns theta1..M (rad, motor side, winding in positive) and f1..M (N) of a CSV or of an MCAP with JointState.

    A log without any f is accepted: then its clock is known to a few milliseconds only and nothing can be identified.
    A column `led` (in an MCAP the position of a joint of that name), 0 or 1, says whether a light was on that the video shows.

    Raises Refused where columns or joints are missing, values not finite, or times do not increase.
    """
    path = Path(path)
    m = neck.M
    if path.suffix == ".mcap":
        series = _from_joint_states(path, neck)
    else:
        forces = [f"f{j + 1}" for j in range(m)]
        series = read_table(path, [f"theta{j + 1}" for j in range(m)], optional=[*forces, LED])
        missing = [name for name in forces if name not in series.columns]
        if 0 < len(missing) < m:
            raise Refused(
                path,
                f"lacks the column{'s' * (len(missing) > 1)} {listed(missing)}",
                "log the forces of all motors, or of none",
            )
    check_time(series.time, str(path))
    for name, values in series.columns.items():
        if not np.all(np.isfinite(values)):
            row = int(np.argmin(np.isfinite(values))) + 1
            raise Refused(path, f"{name} is not a number in sample {row}", "leave such rows out")
    check_size(series.columns, MAX_LOGGED_MAGNITUDE, str(path))
    theta_scale = np.array([motor.theta_sign * motor.theta_scale for motor in neck.motors])
    f_scale = np.array([motor.f_scale for motor in neck.motors])
    columns = numbered_columns("theta", series.matrix("theta") * theta_scale)
    if "f1" in series.columns:
        columns |= numbered_columns("f", series.matrix("f") * f_scale)
    if LED in series.columns:
        light = series.columns[LED]
        if not np.all((light == 0) | (light == 1)):
            raise Refused(path, f"{LED} is neither 0 nor 1 in sample {int(np.argmax((light != 0) & (light != 1))) + 1}")
        columns[LED] = light
    return Series(series.time, columns)


def _from_joint_states(path: Path, neck: Neck) -> Series:
    """Columns theta, f and led as logged, from the one topic that holds the motors: by their joints' names, or by their number."""
    logs = joint_state.read(path).logs
    joints = [motor.joint for motor in neck.motors]
    if all(joint is not None for joint in joints):
        fitting = {topic: log for topic, log in logs.items() if set(joints) <= set(log.names)}
        expected = f"joints {listed(map(str, joints), limit=_SHOWN)}"
    else:
        fitting = {topic: log for topic, log in logs.items() if len(set(log.names) - {LED}) == neck.M}
        expected = f"{neck.M} joints"
    if len(fitting) != 1:
        topics = listed((f"/{topic} has {listed(log.names, limit=_SHOWN)}" for topic, log in logs.items()), "; ")
        count = "no channel" if not fitting else f"{len(fitting)} channels"
        raise Refused(path, f"{count} with {expected} ({topics})", "name the joints in neck.yaml, motors[].joint")
    log = next(iter(fitting.values()))
    unnamed = [k for k, name in enumerate(log.names) if name != LED]
    order = [log.names.index(joint) if joint else unnamed[j] for j, joint in enumerate(joints)]
    force = {} if log.effort is None or np.isnan(log.effort).all() else numbered_columns("f", log.effort[:, order])
    light = {LED: log.position[:, log.names.index(LED)]} if LED in log.names else {}
    return Series(log.time, numbered_columns("theta", log.position[:, order]) | force | light)


def uniformly_sampled(log: Series) -> Series:
    """The log at equal steps, by linear interpolation where rows are missing or late."""
    step = float(np.median(np.diff(log.time)))
    count = round((log.time[-1] - log.time[0]) / step) + 1
    time = log.time[0] + np.arange(count) * (log.time[-1] - log.time[0]) / (count - 1)
    return Series(time, {name: np.interp(time, log.time, values) for name, values in log.columns.items()})
