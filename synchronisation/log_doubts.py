"""What nothing in a log says, and who tells it; and what is to be changed in it before it can be read."""

from collections.abc import Sequence

import numpy as np

from identification.dataset.series import MAX_TIME_S, Array
from identification.dataset.time_unit import MIN_MEDIAN_STEP_S
from synchronisation.column_meaning import Column, column_meaning
from synchronisation.column_units import ANGLE_SCALES, CABLE_SCALES, TORQUE_SCALES
from synchronisation.log_contents import LogContents
from xneck_foundation.one_line import counted, listed
from xneck_foundation.spelling import quoted

_CURRENTS = ("A", "mA")


def doubts_of_rate(rate: float) -> list[str]:
    """What is odd of a rate, Hz: the time is then in another unit."""
    if rate <= 1 / MIN_MEDIAN_STEP_S:
        return []
    return [
        f"the time's unit: as it is taken {rate:.3g} rows follow each other in a second, which no controller writes"
    ]


def doubts_of_angles(angles: Sequence[Column], time: Column | None) -> list[str]:
    """What nothing in the log says of its time and its angles, and who tells it."""
    found = []
    if time is not None and column_meaning(time.name, np.empty(0)).kind != "time":
        found.append(f"which column is the time: {time.name} is taken for it, as it grows evenly")
    if time is not None and time.unit is None:
        found.append("the time's unit: taken for seconds")
    if any(a.unit is None for a in angles):
        found.append("the angles' unit: taken for rad of the motor; `xneck sync` tells another one from the video")
    known = {None, "counts", *ANGLE_SCALES, *CABLE_SCALES}
    if odd := [a for a in angles if a.unit not in known]:
        said = f"the angles' unit {quoted(odd[0].unit or '')} is not known"
        found.append(f"{said}: taken for rad of the motor: write motors[].theta_scale, rad of the motor per unit of it")
    if any(a.unit in CABLE_SCALES for a in angles):
        found.append("whose length it is: taken for the cable's, so that theta_scale is R / rd and changes with them")
    if any(a.unit == "counts" for a in angles):
        found.append(
            "counts of a turn: theta_scale is 6.28319 / counts of neck.yaml, if one step of theta is one count"
        )
    found.append(
        "the angles' sense: taken for positive where cables are wound in; `xneck sync` tells which run the other way"
    )
    return found


def doubts_of_forces(forces: Sequence[Column], unscaled: Sequence[Column]) -> list[str]:
    """What nothing in the log says of its forces, or why it has none."""
    if not forces:
        return [_without_forces(unscaled)]
    found = []
    if any(f.measured for f in forces):
        found.append("commanded forces: these are measured by their names: the commanded ones are needed")
    if any(f.unit is None for f in forces):
        found.append("the forces' unit: taken for N on the cable; `xneck sync` tells another one from the arm's motion")
    if any(f.unit in TORQUE_SCALES for f in forces):
        found.append(
            "whose torque it is: taken for the motor's, so that f_scale is R / rd and changes with them; of the drum it is 1 / rd"
        )
    return found


def _without_forces(unscaled: Sequence[Column]) -> str:
    """Why a log has no forces, and what would make some of its columns forces."""
    if not unscaled:
        return (
            "forces: no column is called one, and without them nothing can be identified: if some are forces, name them in "
            "motors[].f_column"
        )
    names, unit = listed(c.name for c in unscaled), unscaled[0].unit or ""
    do = "write motors[].f_column into neck.yaml, and f_scale:"
    if unscaled[0].kind == "current" or unit in _CURRENTS:
        milli = " times 0.001" if unit == "mA" else ""
        constant = f"that constant (N m/A) times R / rd{milli}"
        return f"forces: {names} are currents, which the motor's torque constant makes forces: {do} {constant}"
    return f"forces: {names} are in {quoted(unit)}, which is no unit that is known: {do} N on the cable per unit"


def late_stamps(stamps: Array) -> list[str]:
    """What keeps stamps (T,), s, from being read."""
    if np.abs(stamps).max() <= MAX_TIME_S:
        return []
    return [f"times of up to {np.abs(stamps).max():.3g} s are too late to be stamped: subtract the first time from all"]


def missing_numbers(contents: LogContents, columns: Sequence[Column]) -> list[str]:
    """Rows in which one of the columns holds no number, as nothing that is read may."""
    finite = np.all([np.isfinite(contents.columns[c.name]) for c in columns], axis=0)
    if finite.all():
        return []
    names = listed(c.name for c in columns if c.missing)
    first = contents.number(int(np.argmin(finite)))
    return [
        f"{counted(int(np.sum(~finite)), 'row')} without a number in {names}, the first is {first}: leave such rows out"
    ]
