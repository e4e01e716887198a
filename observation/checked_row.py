"""A row as an observer takes it: numbers, as many as the arm has, later than the row before."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from xneck_foundation.errors import Refused

Array = NDArray[np.float64]


def checked_numbers(what: str, values: ArrayLike, count: int) -> Array:
    """Numbers (count,), NaN among them. Raises Refused where they are none, or not so many."""
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise Refused("observe", f"{what} holds no numbers ({error})", f"give {count} numbers: rad, N") from error
    if array.shape != (count,):
        raise Refused("observe", f"{what} has the shape {array.shape}, expected ({count},)", "one for each, in a row")
    return array


def checked_frame(angles: ArrayLike, sigma: ArrayLike | None, joints: int) -> tuple[Array, Array]:
    """Angles (N,), rad, with their sigmas (N,), of which one may serve all. Raises Refused where one of both is not that."""
    if sigma is None:
        raise Refused("observe", "angles came without their sigma", "say how well they are known, in rad")
    each = np.full(joints, sigma) if np.ndim(sigma) == 0 else sigma
    return checked_numbers("angles", angles, joints), checked_numbers("sigma", each, joints)


def check_later(time: float, before: float) -> None:
    """Raises Refused where a row is not later than the one before, s."""
    if not time > before:
        word = "stands still" if time == before else "goes back" if time < before else "is no number"
        do = "give each row once, in the order of time; after a new beginning call `restart`"
        raise Refused("observe", f"time {word}: {time:g} s after {before:g} s", do)
