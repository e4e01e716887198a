"""Choosing causes jointly: columns of all effects side by side, the base model's and the nuisances' fitted along in every choice.

All is linear here and costs no more than products that exist already: what stands in every choice is eliminated once, and a choice
is a small system of equations. Numbers keep to their least values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.bounded_least_squares import bounded_minimum
from diagnosis.comparison import Index
from diagnosis.elimination import Eliminated

Array = NDArray[np.float64]

_RIDGE = 1e-7
"""of a column's own product"""
_MAX_ROUNDS = 30
"""of taking, giving up and exchanging"""


@dataclass(frozen=True)
class Option:
    """An effect in one of its shapes at one of its places."""

    effect: str
    columns: Index
    low: Array
    """least values of its columns' numbers"""
    number_count: int
    """of numbers that it is fitted by: a shape's too, which has columns only where it was fitted"""


@dataclass(frozen=True)
class Simpler:
    """By how much less an option with fewer numbers may take from the loss and be taken all the same."""

    share: float
    """of the most that any takes"""
    least_loss: Callable[[float], float]
    """of what the best one leaves: the loss that is worth a name, which a simpler one must not leave beside it"""


class Choices:
    """The loss of any choice of options, none of which a hypothesis holds."""

    def __init__(self, system: Eliminated, options: Sequence[Option]) -> None:
        self._G, self._b, self._loss, self._first = system.G, system.b, system.loss, system.first
        self.options = tuple(options)
        self._known: dict[tuple[int, ...], float] = {}

    def loss(self, chosen: Sequence[int]) -> float:
        """With these options, by number."""
        key = tuple(sorted(chosen))
        if key not in self._known:
            self._known[key] = self._minimum(key)
        return self._known[key]

    def _minimum(self, chosen: tuple[int, ...]) -> float:
        if not chosen:
            return self._loss
        use = np.concatenate([self.options[i].columns for i in chosen]) - self._first
        G, b = self._G[np.ix_(use, use)], self._b[use]
        # what nothing tells apart is told by a little of itself
        G = G + np.diag(_RIDGE * np.diag(G))
        x = bounded_minimum(G, b, np.concatenate([self.options[i].low for i in chosen]))
        return self._loss - 2 * float(x @ b) + float(x @ G @ x)


def chosen_jointly(
    choices: Choices,
    start: Sequence[int],
    least_gain: Callable[[int, float], float],
    simpler: Simpler,
) -> list[int]:
    """The options that are worth it together, by number, beginning with those of `start`.

    least_gain: what an option must take at least from the loss that it is added to, and one of `start`, which was fitted, be
    surpassed by. simpler: by how much less an option with fewer numbers may take and be taken all the same.
    """
    chosen = list(start)
    for _ in range(_MAX_ROUNDS):
        before = list(chosen)
        chosen = _without_needless(choices, chosen, least_gain)
        chosen = _exchanged(choices, chosen, start, least_gain, simpler)
        if (best := best_addition(choices, chosen, least_gain, simpler)) is not None:
            chosen.append(best)
        if sorted(chosen) == sorted(before):
            break
    return chosen


def best_addition(
    choices: Choices, chosen: Sequence[int], least_gain: Callable[[int, float], float], simpler: Simpler
) -> int | None:
    """The option that is best added to those chosen, by number; None where none is worth it. As `chosen_jointly`."""
    loss, taken = choices.loss(chosen), {choices.options[i].effect for i in chosen}
    gains = {
        i: loss - choices.loss([*chosen, i]) for i, option in enumerate(choices.options) if option.effect not in taken
    }
    worth = {i: gain for i, gain in gains.items() if gain > least_gain(i, loss)}
    return simplest(choices.options, worth, loss, simpler) if worth else None


def simplest(options: Sequence[Option], gains: dict[int, float], loss: float, simpler: Simpler) -> int:
    """Of options that gain nearly as much as the best from a loss, the one with the fewest numbers."""
    most = max(gains.values())
    less = min(simpler.share * most, simpler.least_loss(loss - most))
    near = [i for i, gain in gains.items() if gain >= most - less]
    return min(near, key=lambda i: (options[i].number_count, -gains[i]))


def _without_needless(choices: Choices, chosen: Sequence[int], least_gain: Callable[[int, float], float]) -> list[int]:
    kept = list(chosen)
    while kept:
        loss = choices.loss(kept)
        lacking = {}
        for i in kept:
            without = choices.loss([k for k in kept if k != i])
            lacking[i] = (without - loss) / max(least_gain(i, without), 1e-300)
        weakest = min(kept, key=lambda i: lacking[i])
        if lacking[weakest] > 1:
            break
        kept.remove(weakest)
    return kept


def _exchanged(
    choices: Choices,
    chosen: Sequence[int],
    fitted: Sequence[int],
    least_gain: Callable[[int, float], float],
    simpler: Simpler,
) -> list[int]:
    """With every option exchanged for another one that leaves less, as long as one does; what was fitted, for plainly less."""
    kept = list(chosen)
    for place, i in enumerate(chosen):
        others = [k for k in kept if k != i]
        taken = {choices.options[k].effect for k in others}
        without = choices.loss(others)
        gains = {
            k: without - choices.loss([*others, k])
            for k, option in enumerate(choices.options)
            if option.effect not in taken
        }
        best = simplest(choices.options, gains, without, simpler)
        margin = least_gain(i, without - gains[i]) if i in fitted else 0.0
        if gains[best] > gains[i] + margin or choices.options[best].number_count < choices.options[i].number_count:
            kept[place] = best
    return kept
