"""A JointState channel as it is read, whatever its encoding, and what its joints' names must be."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from xneck_foundation.one_line import listed, shortened

Array = NDArray[np.float64]

STAMP_SECONDS = 2**31
"""a ROS stamp's seconds lie within +- so many: an int32"""
NANOSECONDS = 1_000_000_000
_SHOWN = 60
"""characters of names that are shown"""


@dataclass(frozen=True)
class JointStateChannel:
    """A JointState channel: time (T,), s; position and effort of shape (T, joints), NaN where not given, None where never."""

    names: tuple[str, ...]
    time: Array
    position: Array
    effort: Array | None


def check_names(names: Sequence[str]) -> None:
    """Raises ValueError unless there are names, and every joint has one of its own."""
    if not names:
        raise ValueError("name is empty: no joint is named")
    if "" in names:
        raise ValueError(f"name[{names.index('')}] is an empty text")
    name, count = Counter(names).most_common(1)[0]
    if count > 1:
        raise ValueError(f"{count} joints are called {shortened(name, _SHOWN)}")


def check_lengths(joints: int, lengths: dict[str, int]) -> None:
    """Raises ValueError where position, velocity or effort, by their names, have another length than `joints`, or 0."""
    for word, length in lengths.items():
        if length not in (0, joints):
            raise ValueError(f"{length} values of {word} for {joints} names")
    if not lengths["position"]:
        others = [word for word, length in lengths.items() if length]
        raise ValueError(f"holds no positions{', only ' * bool(others)}{listed(others)}")


def joined(parts: Sequence[JointStateChannel]) -> JointStateChannel:
    """Parts of one channel that follow each other, as one, in the first one's order. Raises ValueError where joints differ."""
    names = parts[0].names
    parts = [_in_order(names, part) for part in parts]
    time, position = (np.concatenate([getattr(part, of) for part in parts]) for of in ("time", "position"))
    effort = None
    if any(part.effort is not None for part in parts):
        effort = np.concatenate([np.full_like(p.position, np.nan) if p.effort is None else p.effort for p in parts])
    return JointStateChannel(names, time, position, effort)


def _in_order(names: tuple[str, ...], part: JointStateChannel) -> JointStateChannel:
    if part.names == names:
        return part
    order = order_of(names, part.names)
    effort = None if part.effort is None else part.effort[:, order]
    return JointStateChannel(names, part.time, part.position[:, order], effort)


def order_of(before: Sequence[str], after: Sequence[str]) -> list[int]:
    """Where each of a channel's joints, as the messages before name them, stands in a later one.

    Raises ValueError where the joints are not the same."""
    if len(before) != len(after) or set(before) != set(after):
        was, now = listed(before, limit=_SHOWN), listed(after, limit=_SHOWN)
        raise ValueError(f"the joints' names change on the way, from {was} to {now}")
    return [after.index(name) for name in before]
