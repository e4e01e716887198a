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

    A scale of a motor that is given may hold more than the unit, as the gear of an angle at the drum: only one that nobody gave is
    known to be wrong. angles, forces: the motors' columns; below_header: what a row of units holds, by column, where there is one.
    """
    time = neck.log.time_column
    unit = _unit(below_header.get(time, ""))
    if unit in TIME_SCALES and not np.isclose(neck.log.time_scale, TIME_SCALES[unit], rtol=_SAME):
        raise _another(path, time, unit, "log.time_scale", "s", neck.log.time_scale, TIME_SCALES[unit])
    for motor, angle, force in zip(neck.motors, angles, forces, strict=True):
        for column, key, scale, per_unit, scales in (
            (angle, "motors[].theta_scale", motor.theta_scale, "rad of the motor", ANGLE_SCALES),
            (force, "motors[].f_scale", motor.f_scale, "N on the cable", FORCE_SCALES),
        ):
            unit = _said_of(column, below_header)
            if unit and abs(scale) == 1.0 != scales.get(unit):
                raise _another(path, column, unit, key, per_unit, scale, scales.get(unit))


def _said_of(column: str, below_header: Mapping[str, str]) -> str:
    """The unit that is said of a column; nothing where none is. A letter in a name's brackets may mean anything."""
    in_name = without_brackets(column)[1]
    return _unit(below_header.get(column, "")) or (_unit(in_name) if len(in_name) > 1 or in_name in _SIGNS else "")


def _unit(text: str) -> str:
    known = unit_of_text(text)
    return known[0] if known else ""


def _another(path: Path, column: str, unit: str, key: str, per_unit: str, scale: float, known: float | None) -> Refused:
    """The refusal of a column in a unit that a key of neck.yaml does not say; known: what that is, where the unit tells it."""
    what = f"column {column} is in {quoted(unit)}, and {key} of neck.yaml is {scale:.6g}"
    told = "" if known is None else f": {known:.6g}"
    helps = f"; `xneck logs {path.name}` helps" if known is None else ", or correct the unit that the file says"
    return Refused(path, what, f"write {key}{told}, {per_unit} per {unit}{helps}")
