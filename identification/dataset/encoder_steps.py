"""The steps in which logged motor angles move, which say how finely an encoder is read.

A description may say lines where the drive counts four edges of each, or a logger may round more coarsely than the encoder counts.
Noise that is taken for less, or for more, than it is makes every verdict about the motors untrue.
"""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from mechanism.description import Neck

Array = NDArray[np.float64]

MIN_MOVES = 100
"""rows in which a motor moved, that say in which steps (docs/thresholds.md)"""
MIN_COHERENCE = 0.9
"""length of the mean of exp(2 pi i move / step), from which on moves are multiples of a step (docs/thresholds.md)"""
SAME_STEP = 0.01
"""share by which two steps may differ that are one (docs/thresholds.md)"""
_EDGES = (2.0, 4.0)
"""of a line of an encoder, that drives count"""
_ROWS = 300_000
"""of a log, that are looked at: ten minutes"""
_MOVES = 5000
"""of a log, evenly over it, that are looked at: they tell a step to a thousandth"""
_LARGEST_MULTIPLE = 12.0
"""steps in a move, beyond which an error of the step counts for too much"""
_DIVISORS = range(1, 7)
"""of the smallest moves, that may be the step"""
_REST_SHARE = 0.2
"""of rows in which a motor of one multiple stands still: what moves evenly and is not counted never does"""
_SMALLEST_SHARE = 0.01
"""of the moves, that are no more than the smallest step: single ones may be anything"""


def count_angles(neck: Neck, log: Series) -> Array:
    """Angle of one step of each motor's encoder, (M,), rad: as its log shows, or as described where that shows none.

    log: as the controller wrote it, in our units. Steps that are finer by a whole number are believed where drives make them, of
    two or four edges to a line: a filter of so many rows leaves such steps too, and more noise than they say.
    """
    described = neck.count_angles
    measured = measured_steps(log.part(slice(_ROWS)).matrix("theta"))
    if len(measured) != len(described):
        return described
    finer = described / measured
    whole = np.rint(finer)
    is_filtered = (np.abs(finer - whole) < SAME_STEP * finer) & (whole > 1) & ~np.isin(whole, _EDGES)
    return np.where(np.isfinite(measured) & ~is_filtered, measured, described)


def measured_steps(theta: Array) -> Array:
    """The step of which all moves of each motor are multiples, (M,), NaN where there is none; theta: (T, M), as logged."""
    return np.array([_step(column) for column in theta.T])


def _step(theta: Array) -> float:
    """Of one motor, (T,); NaN where its moves are no multiples of anything."""
    theta = theta[np.isfinite(theta)]
    if len(theta) < MIN_MOVES:
        return np.nan
    moves = np.abs(np.diff(theta))
    moved = moves[moves > 1e-9 * np.max(np.abs(theta))]
    if len(moved) < MIN_MOVES:
        return np.nan
    stands = 1 - len(moved) / len(moves)
    moved = moved[:: max(1, len(moved) // _MOVES)]
    smallest = float(np.quantile(moved, _SMALLEST_SHARE))
    for divisor in _DIVISORS:
        step, coherence, one_multiple = _fitted(moved, smallest / divisor)
        if coherence >= MIN_COHERENCE:
            return step if stands >= _REST_SHARE or not one_multiple else np.nan
    return np.nan


def _fitted(moved: Array, step: float) -> tuple[float, float, bool]:
    """A step fitted to the moves about its multiples, how well they are such, and whether they are all of one multiple."""
    multiples = np.zeros(0)
    for largest in (2.5, _LARGEST_MULTIPLE / 2, _LARGEST_MULTIPLE):
        near = moved[moved < (largest + 0.5) * step]
        multiples = np.rint(near / step)
        power = float(multiples @ multiples)
        if not power:
            return step, 0.0, True
        step = float(multiples @ near) / power
    near = moved[moved < (_LARGEST_MULTIPLE + 0.5) * step]
    coherence = float(np.abs(np.mean(np.exp(2j * np.pi * near / step)))) if len(near) >= MIN_MOVES / 2 else 0.0
    return step, coherence, bool(np.ptp(multiples) == 0)
