"""What is known of an arm to about a per cent only: small errors of it are no cause, and must not be taken for one."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.diagnosis.point import Place

Array = NDArray[np.float64]

_ABOUT = 0.006
"""standard deviation of a drawing's number, relative: even within 1 %"""
_TURNED = 0.0012
"""of what is turned on a lathe"""
_OF_MECHANISMS = (
    "L", "b", "r", "top_mass", "diagonal_mass", "top_inertia", "diagonal_inertia", "spring_stiffness", "spring_free_length",
)  # fmt: skip
WALL = 3.4
"""standard deviations beyond which a nuisance does not go: 2 %"""


def nuisances(at: Place) -> tuple[tuple[str, ...], Array]:
    """Names, and what one sigma of each does to the residuals, (C, S, Q); the clock's and the angles' own come last."""
    arm, names, columns = at.signals.arm, [], []
    fields = [(f, _ABOUT, arm.N) for f in _OF_MECHANISMS] + [("motor_inertia", _ABOUT, arm.M), ("drum", _TURNED, arm.M)]
    for field, sigma, count in fields:
        value = getattr(arm, field)
        for i in range(count):
            more = np.where(np.arange(count) == i, 1 + sigma, 1.0)
            columns.append(at.slow.change(arm=replace(arm, **{field: value * more})))
            names.append(f"{field} {i + 1}")
    return tuple(names), np.stack(columns, axis=-1)


def of_recording(at: Place) -> Array:
    """What one sigma of the recording's own errors does: its clock's offset and skew, (C, S, 2)."""
    s = at.signals
    age = s.time[s.low_pass.kept] - s.time.mean()
    offset, skew = s.clock_sigma
    moves = (at.slow.late(offset), at.slow.late(skew * age))
    return np.stack([at.slow.change(turned=move) for move in moves], axis=-1)
