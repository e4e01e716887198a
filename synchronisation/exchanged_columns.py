"""Columns that are exchanged, by what an exchange leaves of the cables' winding that travel and force do not explain.

Neither units nor senses matter to it, so that it is asked before these: a motor that is told another one's angle seems to have any
unit, and to pull the wrong way.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.log_regression import LoggedMotion, unexplained_winding
from synchronisation.swapped_order import swapped_order

Array = NDArray[np.float64]

MAX_SHARE_LEFT = 0.75
"""of what is unexplained of the cables that an exchange is about: what it leaves of it at most, to be named (docs/thresholds.md)"""
MAX_LEFT_OF_CABLE = 0.95
"""of what is unexplained of each of these (docs/thresholds.md)"""
MAX_LEFT_BY_RIVAL = 1.5
"""times what the best exchange leaves: another one that leaves no more may be it as well (docs/thresholds.md)"""


@dataclass(frozen=True)
class Exchange:
    """Two columns, or two motors, that are in each other's places."""

    words: str
    """which, and which others it may be as well"""
    left: float
    """m, RMS over all cables, that it leaves unexplained"""
    described: float
    """m, that the columns leave as they are"""


def exchanged_columns(arm: Arm, motion: LoggedMotion) -> Exchange | None:
    """The exchange that explains the motion best; None where none does far better than the columns as they are."""
    described = unexplained_winding(motion, range(arm.M))
    good = []
    for words, undone, cables in _undone(arm, motion):
        left = described.copy()
        left[cables] = unexplained_winding(undone, cables)
        if _is_better(left, described):
            good.append((_rms(left), words))
    if not good:
        return None
    good.sort()
    least = good[0][0]
    words = [words for left, words in good if left <= MAX_LEFT_BY_RIVAL * least]
    return Exchange(", or ".join(words), least, _rms(described))


def _is_better(left: Array, described: Array) -> bool:
    """Whether an exchange leaves less of every cable that it is about, and plainly less of them all."""
    about = left != described
    if not about.any() or np.any(left[about] > MAX_LEFT_OF_CABLE * described[about]):
        return False
    return _rms(left[about]) < MAX_SHARE_LEFT * _rms(described[about])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _undone(arm: Arm, motion: LoggedMotion) -> Iterator[tuple[str, LoggedMotion, list[int]]]:
    """Every exchange of two motors' angles, forces, or both, and of two joints' angles.

    Words, the motion with it undone, and the cables that it may be about."""
    for a, b in combinations(range(arm.M), 2):
        order = swapped_order(arm.M, a, b)
        turned = replace(motion, travel=motion.travel[:, order], dry_friction=motion.dry_friction[:, order])
        yield f"theta{a + 1} and theta{b + 1} are swapped", turned, [a, b]
        if motion.force.shape[1]:
            force = motion.force[:, order]
            yield f"f{a + 1} and f{b + 1} are swapped", replace(motion, force=force), [a, b]
            yield f"motors {a + 1} and {b + 1} are swapped, theta and f", replace(turned, force=force), [a, b]
    for a, b in combinations(range(arm.N), 2):
        alpha = motion.alpha[:, swapped_order(arm.N, a, b)]
        undone = replace(motion, winding=cable_winding(arm, alpha))
        yield f"alpha{a + 1} and alpha{b + 1} are swapped", undone, list(range(arm.M))
