"""Units that a table says of its columns, in brackets of their names or in a row below them, against those of neck.yaml."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from mechanism.description import Neck
from synchronisation.column_units import (
    ANGLE_SCALES,
    FORCE_SCALES,
    TIME_SCALES,
    unit_of_text,
    without_brackets,
)
from xneck_foundation.errors import Refused
from xneck_foundation.spelling import quoted

_SIGNS = ("%", "°")
_SAME = 1e-3
"""relative difference of scales that are written with fewer digits"""


def check_units(
    path: Path, neck: Neck, angles: Sequence[str], forces: Sequence[str], below_header: Mapping[str, str]
) -> None:
    """Raises Refused where a column is in another unit than neck.yaml takes its numbers in.

    angles, forces: the motors' columns; below_header: what a row of units holds, by column, where there is one."""
    time = neck.log.time_column
    if (unit := _unit(below_header.get(time, ""))) in TIME_SCALES:
        _check(path, time, unit, "log.time_scale", neck.log.time_scale, TIME_SCALES[unit])
    for motor, angle, force in zip(neck.motors, angles, forces, strict=True):
        if unit := _said_of(angle, below_header):
            _check(path, angle, unit, "motors[].theta_scale", motor.theta_scale, ANGLE_SCALES.get(unit))
        if unit := _said_of(force, below_header):
            _check(path, force, unit, "motors[].f_scale", abs(motor.f_scale), FORCE_SCALES.get(unit))


def _said_of(column: str, below_header: Mapping[str, str]) -> str:
    """The unit that is said of a column; nothing where none is. A letter in a name's brackets may mean anything."""
    in_name = without_brackets(column)[1]
    return _unit(below_header.get(column, "")) or (_unit(in_name) if len(in_name) > 1 or in_name in _SIGNS else "")


def _unit(text: str) -> str:
    known = unit_of_text(text)
    return known[0] if known else ""


def _check(path: Path, column: str, unit: str, key: str, scale: float, known: float | None) -> None:
    """Refuses a scale that is not the unit's; where that is not known by the unit alone, one that nobody has given."""
    if known is not None and not np.isclose(scale, known, rtol=_SAME):
        said = f"column {column} is in {quoted(unit)}, and {key} of neck.yaml is {scale:.6g}"
        raise Refused(path, said, f"write {key}: {known:.6g}, or correct the unit that the file says")
    if known is None and scale == 1.0:
        said = f"column {column} is in {quoted(unit)}, which neck.yaml's {key} does not say in {_PLAIN[key]}"
        raise Refused(path, said, f"write {key}, {_PLAIN[key]} per {unit}; `xneck logs {path.name}` helps")


_PLAIN = {"log.time_scale": "s", "motors[].theta_scale": "rad of the motor", "motors[].f_scale": "N on the cable"}
"""in what neck.yaml's scales are, of one unit of the log"""
