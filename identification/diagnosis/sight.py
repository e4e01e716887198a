"""What recordings could show: which effects they would reveal, and which of them look alike in them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.diagnosis.comparison import Comparison, Group
from identification.diagnosis.naming import MATERIAL, Search

Array = NDArray[np.float64]

_VISIBLE = 5.0
"""times what a person calls a change: an effect of that size should show"""


@dataclass(frozen=True)
class Sight:
    """effects: names. alike[i, j]: share of what effect i does that effect j could feign. told: loss that a visible one makes."""

    effects: tuple[str, ...]
    alike: Array
    """(E, E)"""
    share: Array
    """of the loss, that each would take when it is of a size that should show, (E,)"""

    @property
    def blind(self) -> tuple[str, ...]:
        """Effects that would not show."""
        return tuple(name for name, share in zip(self.effects, self.share, strict=True) if share < MATERIAL)


def sight(found: Search) -> Sight:
    """Of the search's recordings, at the base model."""
    now = found.base
    loss = found.end.fit().loss
    arm = now.point.hypothesis.arm
    groups = {group.effect.name: group for group in now.groups}
    names = tuple(groups)
    # of an effect that may sit in one place alone, the place where it shows most
    targets, alone = [], []
    for group in groups.values():
        wheres = group.effect.wheres(arm)
        options = [_target(now, group, w.columns) for w in (wheres[1:] or wheres)]
        left = [_left(now, option, None) for option in options]
        targets.append(options[int(np.argmax(left))])
        alone.append(max(left))
    seen = np.array(alone)
    alike = np.array(
        [
            [1.0 if a == b else 1 - _left(now, target, groups[b]) / max(whole, 1e-12) for b in names]
            for a, target, whole in zip(names, targets, alone, strict=True)
        ]
    )
    return Sight(names, alike, seen / (loss + seen))


def _target(now: Comparison, group: Group, columns: tuple[int, ...]) -> Array:
    """An effect in a place, of a size that should show, as numbers of all columns."""
    numbers = np.zeros(len(now.sigma))
    numbers[group.columns[list(columns)]] = _VISIBLE
    return numbers


def _left(now: Comparison, target: Array, other: Group | None) -> float:
    """Loss that an effect makes, with another one to explain it."""
    quiet = now.silent().shifted(target)
    return quiet.fit(() if other is None else other.columns).loss
