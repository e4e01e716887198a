"""Columns that are exchanged, or angles that mean another thing, by what undoing it leaves of the cables' winding unexplained.

What travel and force explain of it is taken off. Neither units nor senses matter to it, so that it is asked before these: a motor
that is told another one's angle seems to have any unit, and to pull the wrong way.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mechanism.arm import Arm
from synchronisation.angle_meanings import other_meanings
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.log_regression import LoggedMotion, unexplained_winding
from synchronisation.swapped_order import order_words, swapped_order

Array = NDArray[np.float64]

_Undone = tuple[str, str, LoggedMotion, list[int]]
"""what may be wrong and what to do about it, in words; the motion with it undone, and the cables that it may be about"""
_EXCHANGE = "exchange these columns, or what neck.yaml says of them"
MAX_SHARE_LEFT = 0.75
"""of what is unexplained of the cables that an exchange is about: what it leaves of it at most, to be named (docs/thresholds.md)"""
MAX_SHARE_LEFT_AGAINST = 0.35
"""the same where all motors run against the camera: in a mirrored picture a left cable does nearly as a right one
(docs/thresholds.md)"""
MAX_LEFT_OF_CABLE = 0.95
"""of what is unexplained of each of these (docs/thresholds.md)"""
MAX_LEFT_BY_RIVAL = 1.5
"""times what the best exchange leaves: another one that leaves no more may be it as well (docs/thresholds.md)"""


@dataclass(frozen=True)
class Exchange:
    """Columns, or two motors, in each other's places, or angles that are not those from bar to bar."""

    words: str
    """which, and which others it may be as well"""
    remedy: str
    """what to do about the first of these"""
    left: float
    """m, RMS over all cables, that it leaves unexplained"""
    described: float
    """m, that the columns leave as they are"""


def exchanged_columns(arm: Arm, motion: LoggedMotion) -> Exchange | None:
    """The exchange that explains the motion best, with those that come on top; None where none does far better than no exchange."""
    described = unexplained_winding(motion, range(arm.M))
    good = []
    for words, remedy, undone, cables in (
        *_columns_undone(arm, motion),
        *_forces_reordered(arm, motion),
        *_angles_undone(arm, motion),
    ):
        left = described.copy()
        left[cables] = unexplained_winding(undone, cables)
        if _is_better(left, described):
            good.append((_rms(left), words, remedy, undone))
    if not good:
        return None
    good.sort(key=lambda tried: tried[0])
    least, best, remedy, undone = good[0]
    words = [words for left, words, *_ in good if left <= MAX_LEFT_BY_RIVAL * least]
    more = exchanged_columns(arm, undone)
    if more is not None and remedy == more.remedy == _EXCHANGE:
        words, least = [f"{best}; and {more.words}"], more.left
    if np.all(motion.signs < 0) and least > MAX_SHARE_LEFT_AGAINST * _rms(described):
        return None
    return Exchange(", or ".join(words), remedy, least, _rms(described))


def _is_better(left: Array, described: Array) -> bool:
    """Whether an exchange leaves less of every cable that it is about, and plainly less of them all."""
    about = left != described
    if not about.any() or np.any(left[about] > MAX_LEFT_OF_CABLE * described[about]):
        return False
    return _rms(left[about]) < MAX_SHARE_LEFT * _rms(described[about])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _columns_undone(arm: Arm, motion: LoggedMotion) -> Iterator[_Undone]:
    """Every exchange of two motors' angles, forces, or both, and of two joints' angles."""
    for a, b in combinations(range(arm.M), 2):
        order = swapped_order(arm.M, a, b)
        turned = replace(motion, travel=motion.travel[:, order], dry_friction=motion.dry_friction[:, order])
        yield f"theta{a + 1} and theta{b + 1} are swapped", _EXCHANGE, turned, [a, b]
        if motion.force.shape[1]:
            force = motion.force[:, order]
            yield f"f{a + 1} and f{b + 1} are swapped", _EXCHANGE, replace(motion, force=force), [a, b]
            yield (
                f"motors {a + 1} and {b + 1} are swapped, theta and f",
                _EXCHANGE,
                replace(turned, force=force),
                [a, b],
            )
    for a, b in combinations(range(arm.N), 2):
        alpha = motion.alpha[:, swapped_order(arm.N, a, b)]
        yield f"alpha{a + 1} and alpha{b + 1} are swapped", _EXCHANGE, *_with_angles(arm, motion, alpha)


def _forces_reordered(arm: Arm, motion: LoggedMotion) -> Iterator[_Undone]:
    """The forces in the order in which they explain all cables best, where more than two of them have moved."""
    if not motion.force.shape[1]:
        return
    left = np.empty((arm.M, arm.M))
    cables = np.arange(arm.M)
    for shift in range(arm.M):
        column = (cables + shift) % arm.M
        left[cables, column] = unexplained_winding(replace(motion, force=motion.force[:, column]), cables.tolist())
    order = linear_sum_assignment(left**2)[1].tolist()
    moved = [j for j in range(arm.M) if order[j] != j]
    if len(moved) > 2:
        yield order_words("f", order), _EXCHANGE, replace(motion, force=motion.force[:, order]), moved


def _angles_undone(arm: Arm, motion: LoggedMotion) -> Iterator[_Undone]:
    for other in other_meanings(motion.alpha):
        if arm.N < 4 and np.array_equal(other.alpha, motion.alpha[:, ::-1]):
            continue  # of so few joints the first and the last are swapped
        yield other.words, other.remedy, *_with_angles(arm, motion, other.alpha)


def _with_angles(arm: Arm, motion: LoggedMotion, alpha: Array) -> tuple[LoggedMotion, list[int]]:
    """The motion with other angles (K, N), rad, and the cables that it may be about: all."""
    return replace(motion, winding=cable_winding(arm, alpha)), list(range(arm.M))
