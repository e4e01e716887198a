"""What recordings could show: which effects they would reveal, and which of them look alike in them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause_search import Search
from diagnosis.comparison import Comparison, EffectColumns
from diagnosis.effect import Effect
from diagnosis.nuisances import MAX_TOLERANCES
from diagnosis.worth_naming import MIN_LOSS_SHARE
from mechanism.arm import arm_of
from mechanism.description import Neck

Array = NDArray[np.float64]

_VISIBLE_SIZE = 5.0
"""times what a person calls a change: an effect of that size should show (docs/thresholds.md)"""
_VISIBLE_TOLERANCES = 6.0
"""tolerances of the drawing: what lies as far beyond it should show, though a person may call less a change (docs/thresholds.md)"""


@dataclass(frozen=True)
class Detectability:
    """Of E effects, each of a size that should show, where it shows most."""

    effects: tuple[str, ...]
    imitated: Array
    """(E, E): share of what the effect of the row does that the effect of the column could feign"""
    shown: tuple[bool, ...]
    """whether each would show"""
    invisible_places: tuple[tuple[str, str], ...]
    """places in which an effect would not show that would in another: its name, and where"""

    @property
    def invisible(self) -> tuple[str, ...]:
        """Effects that would not show."""
        return tuple(name for name, shows in zip(self.effects, self.shown, strict=True) if not shows)


def detectability(search: Search) -> Detectability:
    """Of the search's recordings, at the base model."""
    comparison = search.every_effect
    loss = search.last.fit.loss
    neck = comparison.linearisation.hypothesis.neck
    arm = comparison.linearisation.hypothesis.arm
    groups = {group.effect.name: group for group in comparison.groups}
    names = tuple(groups)
    # of an effect that may sit in one place alone, the place where it shows most
    most_visible, effect_losses, invisible_places = [], [], []
    for name, group in groups.items():
        placements = group.effect.placements(arm)
        options = [
            (_effect_alone(comparison, group, w.columns, visible_numbers(group.effect, w.columns, neck)), w.label)
            for w in (placements[1:] or placements)
        ]
        losses = [alone.fit().loss for alone, _ in options]
        hidden = [
            label for (_, label), alone in zip(options, losses, strict=True) if not _shows(group.effect, alone, loss)
        ]
        if len(hidden) < len(options):
            invisible_places += [(name, label) for label in hidden]
        most_visible.append(options[int(np.argmax(losses))][0])
        effect_losses.append(max(losses))
    losses_with_another = [[alone.fit(groups[b].columns).loss for b in names] for alone in most_visible]
    effect_loss = np.array(effect_losses)
    imitated = 1 - np.array(losses_with_another) / np.maximum(effect_loss, 1e-12)[:, None]
    np.fill_diagonal(imitated, 1.0)
    shown = tuple(_shows(groups[name].effect, alone, loss) for name, alone in zip(names, effect_losses, strict=True))
    return Detectability(names, imitated, shown, tuple(invisible_places))


def visible_numbers(effect: Effect, columns: Sequence[int], neck: Neck) -> Array:
    """Amounts at which an effect should show, in sizes, (len(columns),): of what the drawing knows to a tolerance far beyond it."""
    beyond = _VISIBLE_TOLERANCES * effect.tolerances(neck) / effect.sizes(arm_of(neck))
    return np.maximum(_VISIBLE_SIZE, beyond[list(columns)])


def _shows(effect: Effect, alone: float, loss: float) -> bool:
    """Whether an effect that makes a loss alone would show beside the loss that there is.

    What has a tolerance shows where it lies further beyond it than chance puts any: its loss is the square of how far."""
    return alone > MAX_TOLERANCES**2 if effect.has_tolerance else alone > MIN_LOSS_SHARE * (loss + alone)


def _effect_alone(comparison: Comparison, group: EffectColumns, columns: tuple[int, ...], amounts: Array) -> Comparison:
    """What an effect of amounts in sizes, (len(columns),), would leave at a place, if there were nothing else."""
    numbers = np.zeros(len(comparison.prior_sigma))
    numbers[group.columns[list(columns)]] = amounts
    return comparison.with_zero_residual().with_fixed(numbers)
