"""What is said of motors whose columns are in another unit, and what they are told to write into neck.yaml."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from synchronisation.log_units import Unit

Array = NDArray[np.float64]

SURE_TOLERANCE = 0.1
"""log of the ratio between a measured factor and a unit's, within which a unit is said to be it; beyond, that it may be it
(docs/thresholds.md)"""


def times(ratios: Array) -> str:
    """Ratios in words: `3.2 times`, `58.9 to 61.1 times`."""
    low, high = (f"{float(r):.0f}" if r >= 100 else f"{float(r):.3g}" for r in (np.min(ratios), np.max(ratios)))
    return f"{low} times" if low == high else f"{low} to {high} times"


def column_names(stem: str, motors: NDArray[np.intp]) -> str:
    """Names of the columns of motors, counted from 0."""
    return ", ".join(f"{stem}{j + 1}" for j in motors)


def is_sure(units: Sequence[Unit], measured: Array) -> bool:
    """Whether measured scales are those of the units to within SURE_TOLERANCE."""
    pairs = zip(units, measured, strict=True)
    return all(abs(np.log(scale / unit.scale)) < SURE_TOLERANCE for unit, scale in pairs)


def unit_named(stem: str, motors: NDArray[np.intp], units: Sequence[Unit], measured: Array, count: int) -> str:
    """That columns of some of `count` motors are in a unit, or may be where that is not sure, in words."""
    columns = stem if len(motors) == count else column_names(stem, motors)
    verb = "may be" if not is_sure(units, measured) else "is" if len(motors) in (1, count) else "are"
    return f"{columns} {verb} in {units[0].name}"


def what_to_write(written: str, key: str, units: Sequence[Unit], measured: Array) -> str:
    """What to write where columns are in a unit, and what else where they may be in one of their own; written: by `to_write`."""
    if is_sure(units, measured):
        return written
    return f"if so, {written}; else motors[].{key} is what one of its own unit is, which {comes_to(measured)}"


def comes_to(measured: Array) -> str:
    """What measured scales come to in the middle."""
    return f"comes to about {np.median(measured):.3g}"


def to_write(key: str, motors: NDArray[np.intp], scales: Sequence[float], count: int) -> str:
    """What to write into neck.yaml."""
    if len(motors) == count and len(set(scales)) == 1:
        return f"write motors[].{key}: {scales[0]:.6g} into neck.yaml"
    lines = ", ".join(f"motors[{j}].{key}: {scale:.6g}" for j, scale in zip(motors, scales, strict=True))
    return f"write {lines} into neck.yaml"
