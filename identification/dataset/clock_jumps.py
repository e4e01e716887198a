"""Jumps of a clock that was set on the way: at midnight, and where summer time begins or ends."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

HOUR_S, DAY_S = 3600.0, 86400.0
MAX_JUMP_ROWS = 5.0
"""rows by which a jump may differ from an hour or a day that a clock was set by (docs/thresholds.md)"""


def stamp(time: float) -> str:
    """A time with its digits, also of seconds since 1970."""
    return f"{time:.13g}"


def refuse_set_clock(
    time: Array, row: int, where: str, number: Callable[[int], int], name: str = "time", second: float = 1.0
) -> None:
    """Refused where times (T,) jump by a day or an hour at a row, with the number to add; second: one in their unit."""
    steps = np.diff(time)
    within = MAX_JUMP_ROWS * float(np.median(np.abs(steps)))
    for jump, occasion in (
        (-DAY_S, "as seconds of a day do at midnight"),
        (DAY_S, "by a day: the clock's date was set"),
        (-HOUR_S, "by an hour, as where summer time ends"),
        (HOUR_S, "by an hour, as where summer time begins"),
    ):
        if abs(steps[row - 1] - jump * second) <= within:
            way = "back" if jump < 0 else "forward"
            told = f"{name} jumps {way} in row {number(row)}, from {stamp(time[row - 1])} to {stamp(time[row])}, {occasion}"
            do = f"{'add' if jump < 0 else 'subtract'} {abs(jump) * second:.13g} "
            raise Refused(where, told, do + f"{'to' if jump < 0 else 'from'} {name} in that row and all below it")
