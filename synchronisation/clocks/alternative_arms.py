"""Arms that are mirrored, or whose joints and cables are numbered otherwise as a whole: do the cables fit one of them better?

Speeds of such an arm correlate nearly as well with the log; only lengths tell, by the little that pulleys and the sides' common
length add. What angles cannot explain of the cables' lengths is compared.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mechanism.arm import Arm
from synchronisation.clocks.cable_equation import CableEquation, CableTerms
from synchronisation.clocks.exchanged_labels import MAX_PERMUTED_JOINTS, MIN_CORRELATION
from synchronisation.clocks.frame_geometry import FrameGeometry, frame_geometry
from synchronisation.clocks.gauss_newton_fit import LINEAR, ClockProblem, ClockSolution, fit_cables
from synchronisation.clocks.signals import relabelled
from synchronisation.clocks.undetermined import ClockUndetermined
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

SUSPICIOUS_M = 1.2e-5
"""m: other arms are tried only where the described one's cables leave more than this (docs/thresholds.md)"""
HEALTHY_M = 3e-5
"""m: another arm's cables may leave at most this for it to be taken for the true one (docs/thresholds.md)"""
MAX_ERROR_RATIO = 0.35
"""another arm may leave at most this share of what the described one leaves (docs/thresholds.md)"""
PULLEY_SIGMA = 0.1
"""ratio: standard deviation of the described arm's pulleys (docs/thresholds.md)"""
MAX_LOOKED_AT = 3
"""other arms that are fitted with the whole law: the nearest by a line for every cable (docs/thresholds.md)"""
MAX_FRAMES = 600
"""frames that suffice to tell arms apart"""


def check_alternative_arms(arm: Arm, problem: ClockProblem, starts: Sequence[float], law: CableTerms) -> None:
    """Refused where an arm that is mirrored or renumbered as a whole leaves much less of the cables' lengths unexplained.

    starts: offsets to fit from, s; law: of the cables."""
    step = max(1, len(problem.frames.time) // MAX_FRAMES)
    problem = replace(problem, frames=problem.frames.part(slice(None, None, step)))
    # drums and pulleys are free for the described arm alone: one that is off must not look like another arm
    error = _smallest_error(problem, starts, replace(law, drum=True), SUSPICIOUS_M, PULLEY_SIGMA)
    if error < SUSPICIOUS_M:
        return
    at = np.clip(problem.frames.time + starts[0], problem.signals.time[0], problem.signals.time[-1])
    travel = problem.signals.travel(at)
    described = (*range(arm.N),)
    orders = permutations(range(arm.N)) if arm.N <= MAX_PERMUTED_JOINTS else [described]
    others = list[_OtherArm]()
    for order, sign in product(orders, (1, -1)):
        if sign > 0 and order == described:
            continue
        frames = _renumbered(arm, problem.frames, order, sign)
        correlation, cables = _paired_cables(frames.winding, sign * travel)
        if correlation < MIN_CORRELATION:
            continue
        other = replace(problem, signals=relabelled(problem.signals, cables, sign), frames=frames)
        others.append(_OtherArm(other, _words(order, sign, cables), _smallest_error(other, starts, LINEAR)))
    for other in sorted(others, key=lambda other: other.roughly)[:MAX_LOOKED_AT]:
        other_error = _smallest_error(other.problem, starts, law)
        if other_error < min(MAX_ERROR_RATIO * error, HEALTHY_M):
            raise Refused(
                "sync",
                f"log and video fit better {other.words}: {1e3 * other_error:.3f} mm are left unexplained "
                f"instead of {1e3 * error:.3f}",
                "check markers.on_bars, theta_sign and the order of the log's columns; this is not corrected by itself",
            )


@dataclass(frozen=True)
class _OtherArm:
    """The problem of an arm that is numbered or mirrored otherwise."""

    problem: ClockProblem
    words: str
    roughly: float
    """m: what cables without creep, damping or friction of another form leave unexplained"""


def _smallest_error(
    problem: ClockProblem, starts: Sequence[float], law: CableTerms, enough: float = 0.0, pulley_sigma: float = 0.0
) -> float:
    """The least that the cables leave unexplained from any of the starts, m; infinite where no fit succeeds.

    enough: m; from a start that leaves less, no further one is tried; pulley_sigma: as in `ModelAssumptions`."""
    cables, least = CableEquation(problem.signals, law), np.inf
    for start in starts:
        with suppress(ClockUndetermined):
            least = min(least, _error(problem.frames, fit_cables(problem, start, cables, pulley_sigma)))
        if least < enough:
            break
    return least


def _error(frames: FrameGeometry, fit: ClockSolution) -> float:
    """RMS of what no angles can explain of the cables' travels, m; with no more cables than joints, of all that is left."""
    joints, cables = frames.Z.shape[1:]
    return frames.unexplained_rms(fit.residual) if cables > joints else float(np.sqrt(np.mean(fit.residual**2)))


def _renumbered(arm: Arm, frames: FrameGeometry, order: tuple[int, ...], sign: int) -> FrameGeometry:
    """The frames with the angles in another order and all of one sign."""
    correlation = frames.correlation[np.ix_(order, order)]
    alpha, sigma = frames.alpha[:, list(order)], frames.sigma[:, list(order)]
    return frame_geometry(arm, frames.time, sign * alpha, sigma, frames.middle, correlation)


def _paired_cables(winding: Array, travel: Array) -> tuple[float, list[int]]:
    """The pairing of windings with travels (F, M), m, that correlates best: its mean correlation, and each winding's travel."""
    predicted, measured = winding - winding.mean(axis=0), travel - travel.mean(axis=0)
    size = np.sqrt(np.sum(predicted**2, axis=0))[:, None] * np.sqrt(np.sum(measured**2, axis=0))
    correlation = (predicted.T @ measured) / np.maximum(size, 1e-12)
    rows, columns = linear_sum_assignment(-correlation)
    return float(np.mean(correlation[rows, columns])), columns.tolist()


def _words(order: tuple[int, ...], sign: int, cables: list[int]) -> str:
    """How the arm would have to be numbered or mirrored."""
    words = []
    if sign < 0:
        words.append("with all signs turned (a mirrored picture, and the other theta_sign for every motor)")
    if order != (*range(len(order)),):
        words.append(
            f"with the angles in the order {', '.join(str(i + 1) for i in order)} and at once the log's columns in "
            f"the order {', '.join(str(j + 1) for j in cables)}"
        )
    return " and ".join(words)
