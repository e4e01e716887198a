"""Units in which loggers write motor angles and forces, and which of them a measured factor is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechanism.description import Motor


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
        Unit("kilograms of force", 9.80665),
        Unit("N m of the motor", motor.R / motor.rd),
        Unit("mN m of the motor", 1e-3 * motor.R / motor.rd),
        Unit("N m of the drum", 1 / motor.rd),
        Unit("mN m of the drum", 1e-3 / motor.rd),
    ]


def unit_of(scale: float, units: Sequence[Unit], tolerance: float) -> Unit | None:
    """The one unit whose scale differs from a measured one by a log ratio below `tolerance`; None for none, or for several."""
    near = [unit for unit in units if abs(np.log(scale / unit.scale)) < tolerance]
    return near[0] if len(near) == 1 else None
