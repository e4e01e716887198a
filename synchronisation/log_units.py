"""Units in which loggers write motor angles and forces, and which of them a measured factor is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechanism.description import Motor

MAX_ADDED_SCATTER = 0.05
"""by how much more the log ratios of measured factors to a unit of each motor's own scatter than the factors themselves, at most
(docs/thresholds.md)"""


@dataclass(frozen=True)
class Unit:
    """A unit by its name, and its factor: what theta_scale or f_scale must be for it."""

    name: str
    scale: float


def theta_units(motor: Motor) -> list[Unit]:
    """Units of a motor's angle; scale: rad on the motor's side per unit."""
    degree, turn, metre = np.pi / 180, 2 * np.pi, motor.R / motor.rd
    units = [
        Unit("radians of the motor", 1.0),
        Unit("milliradians", 1e-3),
        Unit("degrees", degree),
        Unit("turns", turn),
        Unit("encoder counts", turn / motor.counts),
        Unit("encoder counts, four to a line", turn / motor.counts / 4),
        Unit("metres of cable", metre),
        Unit("mm of cable", 1e-3 * metre),
    ]
    if motor.R != 1:
        of_drum = (("radians", 1.0), ("degrees", degree), ("turns", turn))
        units += [Unit(f"{name} of the drum, behind the gear", motor.R * scale) for name, scale in of_drum]
    return units


def force_units(motor: Motor) -> list[Unit]:
    """Units of a motor's force; scale: N on the cable per unit."""
    return [
        Unit("newtons on the cable", 1.0),
        Unit("millinewtons", 1e-3),
        Unit("kilonewtons", 1e3),
        Unit("kilograms of force, or daN (then 10)", 9.80665),
        Unit("N m of the motor", motor.R / motor.rd),
        Unit("mN m of the motor", 1e-3 * motor.R / motor.rd),
        Unit("N m of the drum", 1 / motor.rd),
        Unit("mN m of the drum", 1e-3 / motor.rd),
    ]


def unit_of(scale: float, units: Sequence[Unit], tolerance: float) -> Unit | None:
    """The one unit whose scale differs from a measured one by a log ratio below `tolerance`; None for none, or for several."""
    found = unit_of_motors([scale], [units], tolerance)
    return found[0] if found else None


def unit_of_motors(
    scales: Sequence[float] | NDArray[np.float64], units: Sequence[Sequence[Unit]], tolerance: float
) -> tuple[Unit, ...]:
    """Of each motor the one unit that its measured scale is in, to a log ratio below `tolerance`, and those of all others are in.

    None where there is no such unit, or several. A unit whose scale depends on gear or drum is that of motors which differ as their
    gears and drums do, and not of motors that have one factor in common."""
    measured = np.log(scales)
    by_name = [{unit.name: unit for unit in of_motor} for of_motor in units]
    common = [name for name in by_name[0] if all(name in of_motor for of_motor in by_name)]
    fitting = []
    for name in common:
        found = tuple(of_motor[name] for of_motor in by_name)
        ratio = measured - np.log([unit.scale for unit in found])
        if np.all(np.abs(ratio) < tolerance) and np.std(ratio) < np.std(measured) + MAX_ADDED_SCATTER:
            fitting.append(found)
    return fitting[0] if len(fitting) == 1 else ()
