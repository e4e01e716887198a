"""What recordings could show: which effects they would reveal, and which of them look alike in them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_search import MIN_LOSS_SHARE, Search
from diagnosis.comparison import Comparison, EffectColumns

Array = NDArray[np.float64]

_VISIBLE_SIZE = 5.0
"""times what a person calls a change: an effect of that size should show (docs/thresholds.md)"""


@dataclass(frozen=True)
class Detectability:
    """Of E effects, each of a size that should show, where it shows most."""

    effects: tuple[str, ...]
    imitated: Array
    """(E, E): share of what the effect of the row does that the effect of the column could feign"""
    loss_share: Array
    """of the loss, that each would make, (E,)"""
    invisible_places: tuple[tuple[str, str], ...]
    """places in which an effect would not show that would in another: its name, and where"""

    @property
    def invisible(self) -> tuple[str, ...]:
        """Effects that would not show."""
        return tuple(name for name, share in zip(self.effects, self.loss_share, strict=True) if share < MIN_LOSS_SHARE)


def detectability(search: Search) -> Detectability:
    """Of the search's recordings, at the base model."""
    comparison = search.every_effect
    loss = search.last.fit.loss
    arm = comparison.linearisation.hypothesis.arm
    groups = {group.effect.name: group for group in comparison.groups}
    names = tuple(groups)
    # of an effect that may sit in one place alone, the place where it shows most
    most_visible, effect_losses, invisible_places = [], [], []
    for name, group in groups.items():
        placements = group.effect.placements(arm)
        options = [(_effect_alone(comparison, group, w.columns), w.label) for w in (placements[1:] or placements)]
        losses = [alone.fit().loss for alone, _ in options]
        hidden = [
            label
            for (_, label), alone_loss in zip(options, losses, strict=True)
            if alone_loss < MIN_LOSS_SHARE * (loss + alone_loss)
        ]
        if len(hidden) < len(options):
            invisible_places += [(name, label) for label in hidden]
        most_visible.append(options[int(np.argmax(losses))][0])
        effect_losses.append(max(losses))
    losses_with_another = [[alone.fit(groups[b].columns).loss for b in names] for alone in most_visible]
    effect_loss = np.array(effect_losses)
    imitated = 1 - np.array(losses_with_another) / np.maximum(effect_loss, 1e-12)[:, None]
    np.fill_diagonal(imitated, 1.0)
    return Detectability(names, imitated, effect_loss / (loss + effect_loss), tuple(invisible_places))


def _effect_alone(comparison: Comparison, group: EffectColumns, columns: tuple[int, ...]) -> Comparison:
    """What an effect of a size that should show would leave at a place, if there were nothing else."""
    numbers = np.zeros(len(comparison.prior_sigma))
    numbers[group.columns[list(columns)]] = _VISIBLE_SIZE
    return comparison.with_zero_residual().with_fixed(numbers)
