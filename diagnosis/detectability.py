"""What recordings could show: which effects they would reveal, and which of them look alike in them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_search import MATERIAL, Search
from diagnosis.comparison import Comparison, Group

Array = NDArray[np.float64]

_VISIBLE = 5.0
"""times what a person calls a change: an effect of that size should show"""


@dataclass(frozen=True)
class Detectability:
    """effects: names. alike[i, j]: share of what effect i does that effect j could feign. told: loss that a visible one makes."""

    effects: tuple[str, ...]
    alike: Array
    """(E, E)"""
    share: Array
    """of the loss, that each would take when it is of a size that should show, (E,)"""
    unseen: tuple[tuple[str, str], ...]
    """places in which an effect would not show that would in another: its name, and where"""

    @property
    def blind(self) -> tuple[str, ...]:
        """Effects that would not show."""
        return tuple(name for name, share in zip(self.effects, self.share, strict=True) if share < MATERIAL)


def sight(found: Search) -> Detectability:
    """Of the search's recordings, at the base model."""
    now = found.asked
    loss = found.last.fit.loss
    arm = now.point.hypothesis.arm
    groups = {group.effect.name: group for group in now.groups}
    names = tuple(groups)
    # of an effect that may sit in one place alone, the place where it shows most
    shown, alone, unseen = [], [], []
    for name, group in groups.items():
        wheres = group.effect.wheres(arm)
        options = [(_shown(now, group, w.columns), w.label) for w in (wheres[1:] or wheres)]
        told = [quiet.fit().loss for quiet, _ in options]
        hidden = [label for (_, label), one in zip(options, told, strict=True) if one < MATERIAL * (loss + one)]
        if len(hidden) < len(options):
            unseen += [(name, label) for label in hidden]
        shown.append(options[int(np.argmax(told))][0])
        alone.append(max(told))
    feigned = [[quiet.fit(groups[b].columns).loss for b in names] for quiet in shown]
    most = np.array(alone)
    alike = 1 - np.array(feigned) / np.maximum(most, 1e-12)[:, None]
    np.fill_diagonal(alike, 1.0)
    return Detectability(names, alike, most / (loss + most), tuple(unseen))


def _shown(now: Comparison, group: Group, columns: tuple[int, ...]) -> Comparison:
    """What would be seen of an effect in a place, of a size that should show, and of nothing else."""
    numbers = np.zeros(len(now.sigma))
    numbers[group.columns[list(columns)]] = _VISIBLE
    return now.silent().shifted(numbers)
