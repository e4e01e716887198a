"""How long cables are: taut over pulleys of radius r on the bars' ends, by the turn of the pulleys at which they come and go.

Every portion begins at the lowest point of its pulley on the lower bar and runs outside around it. A string that passes on
goes once around the upper pulley, to its lowest point. Over a strut it crosses between the pulleys of a diagonal, and again
between those of the upper bar.
"""

import numpy as np

from samples.forward_arms.joints import Fold
from samples.forward_arms.plant import Array, Plant

WORDS = ("right", "left", "right_through", "left_through", "strut", "strut_mirrored")
NONE = len(WORDS)
"""stands for a mechanism that a cable does not reach"""


def lengths(plant: Plant, fold: Fold, alpha: Array) -> Array:
    """(M, B), m."""
    r = plant.r
    words = r * _turns(plant, fold, alpha)
    for place, side in ((0, fold.right), (1, fold.left)):
        words[place] += np.sqrt(side**2 - r**2)
        words[place + 2] += side
    words[4:6] += plant.crossing
    return _routed(plant, words).sum(axis=0)


def wraps(plant: Plant, fold: Fold, alpha: Array) -> Array:
    """Angle over which each cable lies on the pulleys of its route, in all, (M, B), rad."""
    return _routed(plant, _turns(plant, fold, alpha)).sum(axis=0)


def wraps_before_spans(plant: Plant, fold: Fold, alpha: Array) -> Array:
    """Of that angle, what lies before the span of each mechanism and behind the one below it, (N, M, B), rad.

    A string that passes on lies on the upper pulley over all but the first quarter of its turn: behind the span. Of a strut's three
    pulleys two are on the upper bar."""
    turns = _turns(plant, fold, alpha)
    behind = np.zeros_like(turns)
    for place, turn in ((2, alpha), (3, -alpha)):
        behind[place] = 3 * np.pi / 2 + turn / 2
    from_entry = turns[4] / 2 + plant.slopes_of_crossing[1]
    for place, turn in ((4, alpha), (5, -alpha)):
        behind[place] = from_entry - turn / 2
    return _before_spans(plant, turns, behind)


def wraps_in_halves(plant: Plant, fold: Fold, alpha: Array) -> Array:
    """As `wraps_before_spans`, where half of what a string winds that passes on lies before the span, and half behind it."""
    turns = _turns(plant, fold, alpha)
    behind = turns / 2
    behind[:2] = 0.0
    return _before_spans(plant, turns, behind)


def _before_spans(plant: Plant, turns: Array, behind: Array) -> Array:
    """Of every word's turns (word, N, B), rad, with what of them is behind its span: before each span, (N, M, B)."""
    before, after = _routed(plant, turns - behind), _routed(plant, behind)
    before[1:] += after[:-1]
    return before


def _turns(plant: Plant, fold: Fold, alpha: Array) -> Array:
    """Of every word on every mechanism, (word, N, B), rad."""
    r, b, L = plant.r, plant.b, plant.L
    diagonal = np.arccos(b / L * fold.half.real)  # between a diagonal and the bars' mean direction
    turns = np.zeros((NONE + 1, *alpha.shape))
    for place, side, turn in ((0, fold.right, alpha), (1, fold.left, -alpha)):
        turns[place] = np.pi / 2 + turn / 2 + np.arcsin(r / side)
        turns[place + 2] = 2 * np.pi + turn
    by_diagonal, by_bar = plant.slopes_of_crossing
    turns[4] = turns[5] = 2 * (np.pi - diagonal + by_diagonal + by_bar)
    return turns


def levers(plant: Plant, fold: Fold) -> Array:
    """Z = -dl/dalpha, (N, M, B), m."""
    r = plant.r
    words = np.zeros((NONE + 1, *fold.mean.shape))
    for place, side, slope, turn in ((0, fold.right, fold.right1, r), (1, fold.left, fold.left1, -r)):
        share = r / side
        words[place] = -slope * np.sqrt(1 - share * share) - turn / 2
        words[place + 2] = -slope - turn
    words[4] = words[5] = r * plant.b * fold.half.imag / fold.mean
    return _routed(plant, words)


def _routed(plant: Plant, words: Array) -> Array:
    """(word, N, B) -> (N, M, B)."""
    return words.take(plant.places_of_words(words.shape[-1]))
