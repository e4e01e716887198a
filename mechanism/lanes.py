"""Many arms side by side: parts (joints, cables) on the first axis, all batch axes as one on the last, the lanes.

Numbers of one part then lie next to each other, and each operation runs over the whole batch at once. What works part by part
(sides, portions of cables, laws) takes either layout. A last axis of 1 serves all lanes.
"""

from collections.abc import Mapping
from dataclasses import fields, replace

import numpy as np

from mechanism.arm import Arm, Array

Shape = tuple[int, ...]
ALL = slice(None)


def to_lanes(values: Array, shape: Shape, part: slice = ALL, axes: int = 1) -> Array:
    """(..., parts) -> (parts, lanes), where leading axes broadcast to `shape`; without any: (parts, 1).

    axes: how many of the last are not lanes. part: of the lanes only these.
    """
    values = np.asarray(values, dtype=float)
    if values.ndim == axes:
        return values[..., None]
    tail = values.shape[values.ndim - axes :]
    flat = np.broadcast_to(values, (*shape, *tail)).reshape(-1, *tail)[part]
    return np.ascontiguousarray(np.moveaxis(flat, 0, -1))


def from_lanes(values: Array, shape: Shape) -> Array:
    """(parts, ..., lanes) -> (*shape, parts, ...)."""
    count = int(np.prod(shape))
    whole = np.moveaxis(np.broadcast_to(values, (*values.shape[:-1], count)), -1, 0)
    return whole.reshape(*shape, *values.shape[:-1])


def arm_in_lanes(arm: Arm, shape: Shape, part: slice = ALL) -> Arm:
    """The arm with arrays (parts, lanes); top_com (N, lanes, 2), gravity (lanes, 2)."""
    moved = {name: to_lanes(getattr(arm, name), shape, part, axes) for name, axes in _arrays().items()}
    moved["top_com"] = np.moveaxis(moved["top_com"], 1, -1)
    moved["gravity"] = moved["gravity"].T
    return replace(arm, **moved)


def shape_of(arm: Arm, values: Mapping[str, Array]) -> Shape:
    """Batch axes of an arm and of its laws' numbers."""
    of_arm = (np.shape(getattr(arm, name))[: np.ndim(getattr(arm, name)) - axes] for name, axes in _arrays().items())
    return np.broadcast_shapes(*of_arm, *(np.shape(value)[:-1] for value in values.values()))


def _arrays() -> dict[str, int]:
    """Names of an arm's arrays, and how many axes of each are not for batches."""
    names = (field.name for field in fields(Arm) if field.name not in ("spring_slack", "routes"))
    return {name: 2 if name == "top_com" else 1 for name in names}
