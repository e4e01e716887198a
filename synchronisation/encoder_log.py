"""The controller's log: motor angles theta and forces f on its own clock, brought into our signs and units."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series, check_size, check_time, numbered
from identification.files import joint_state
from mechanism.description import Neck
from synchronisation.csv_table import read_table
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

LED = "led"
LARGEST = 1e9
"""of any motor angle or force, in whatever unit it is logged"""


def read_log(path: str | Path, neck: Neck) -> Series:
    """Columns theta1..M (rad, motor side, winding in positive) and f1..M (N) of a CSV or of an MCAP with JointState.

    A log without any f is taken as it is: then its clock is known to a few milliseconds only and nothing can be identified.
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
                f"lacks the column{'s' * (len(missing) > 1)} {', '.join(missing)}",
                "log the forces of all motors, or of none",
            )
    check_time(series.time, str(path))
    for name, values in series.columns.items():
        if not np.all(np.isfinite(values)):
            row = int(np.argmin(np.isfinite(values))) + 1
            raise Refused(path, f"{name} is not a number in sample {row}", "leave such rows out")
    check_size(series.columns, LARGEST, str(path))
    turn = np.array([motor.theta_sign * motor.theta_scale for motor in neck.motors])
    force = np.array([motor.f_scale for motor in neck.motors])
    columns = numbered("theta", series.matrix("theta") * turn)
    if "f1" in series.columns:
        columns |= numbered("f", series.matrix("f") * force)
    if LED in series.columns:
        light = series.columns[LED]
        if not np.all((light == 0) | (light == 1)):
            raise Refused(path, f"{LED} is neither 0 nor 1 in sample {int(np.argmax((light != 0) & (light != 1))) + 1}")
        columns[LED] = light
    return Series(series.time, columns)


def _from_joint_states(path: Path, neck: Neck) -> Series:
    logs = joint_state.read(path).logs
    named = [motor.joint for motor in neck.motors]
    if all(name is not None for name in named):
        fitting = {topic: log for topic, log in logs.items() if set(named) <= set(log.names)}
        wanted = f"joints {', '.join(map(str, named))}"
    else:
        fitting = {topic: log for topic, log in logs.items() if len(set(log.names) - {LED}) == neck.M}
        wanted = f"{neck.M} joints"
    if len(fitting) != 1:
        found = "; ".join(f"/{topic} has {', '.join(log.names[:8])}" for topic, log in logs.items())
        word = "no channel" if not fitting else f"{len(fitting)} channels"
        raise Refused(path, f"{word} with {wanted} ({found})", "name the joints in neck.yaml, motors[].joint")
    log = next(iter(fitting.values()))
    unnamed = [k for k, name in enumerate(log.names) if name != LED]
    order = [log.names.index(name) if name else unnamed[j] for j, name in enumerate(named)]
    force = {} if log.effort is None or np.isnan(log.effort).all() else numbered("f", log.effort[:, order])
    light = {LED: log.position[:, log.names.index(LED)]} if LED in log.names else {}
    return Series(log.time, numbered("theta", log.position[:, order]) | force | light)


def uniform(log: Series) -> Series:
    """The log on a clock of equal steps, by linear interpolation where rows are missing or late."""
    step = float(np.median(np.diff(log.time)))
    count = round((log.time[-1] - log.time[0]) / step) + 1
    time = log.time[0] + np.arange(count) * (log.time[-1] - log.time[0]) / (count - 1)
    return Series(time, {name: np.interp(time, log.time, values) for name, values in log.columns.items()})
