"""Many arms side by side: parts (joints, cables) on the first axis, all batch axes as one on the last, of length B.

Numbers of one part then lie next to each other, and each operation runs over the whole batch at once. What works part by part
(sides, portions of cables, laws) takes either layout. A last axis of length 1 serves the whole batch.
"""

from collections.abc import Mapping
from dataclasses import fields, replace

import numpy as np

from mechanism.arm import Arm, Array

Shape = tuple[int, ...]
ALL = slice(None)
_OF_TWO_AXES = ("top_com", "spring_stiffness", "spring_free_length")


def to_batch_last(values: Array, shape: Shape, part: slice = ALL, own_axes: int = 1) -> Array:
    """(..., parts) -> (parts, B), where the leading axes broadcast to `shape`; without any, (parts, 1).

    own_axes: how many of the last axes are no batch axes. part: the entries of the flattened batch that are taken.
    """
    values = np.asarray(values, dtype=float)
    if values.ndim == own_axes:
        return values[..., None]
    tail = values.shape[values.ndim - own_axes :]
    flat = np.broadcast_to(values, (*shape, *tail)).reshape(-1, *tail)[part]
    return np.ascontiguousarray(np.moveaxis(flat, 0, -1))


def from_batch_last(values: Array, shape: Shape) -> Array:
    """(parts, ..., B) -> (*shape, parts, ...)."""
    count = int(np.prod(shape))
    batch_first = np.moveaxis(np.broadcast_to(values, (*values.shape[:-1], count)), -1, 0)
    return batch_first.reshape(*shape, *values.shape[:-1])


def arm_batch_last(arm: Arm, shape: Shape, part: slice = ALL) -> Arm:
    """The arm with arrays (parts, B); top_com (N, B, 2), gravity (B, 2), the springs' (2, N, B)."""
    moved = {name: to_batch_last(getattr(arm, name), shape, part, axes) for name, axes in _own_axes().items()}
    moved["top_com"] = np.moveaxis(moved["top_com"], 1, -1)
    moved["gravity"] = moved["gravity"].T
    return replace(arm, **moved)


def batch_shape(arm: Arm, values: Mapping[str, Array]) -> Shape:
    """Shape of the batch axes of an arm and of its laws' values."""
    of_arm = (np.shape(getattr(arm, name))[: np.ndim(getattr(arm, name)) - axes] for name, axes in _own_axes().items())
    return np.broadcast_shapes(*of_arm, *(np.shape(value)[:-1] for value in values.values()))


def _own_axes() -> dict[str, int]:
    """How many axes of each array of an arm are no batch axes, by the array's name."""
    names = (field.name for field in fields(Arm) if field.name not in ("spring_slack", "routes"))
    return {name: 2 if name in _OF_TWO_AXES else 1 for name in names}
