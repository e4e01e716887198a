"""Signs and labels: which exchange of angles, cables or signs would make log and video show the same motion.

Nothing is corrected in silence: the exchange is named, so that the file that states it can be set right.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.signal import correlate

from mechanism.arm import Arm
from synchronisation.clocks.cables import CableTerms, Frames, frames_of, part_of, wound
from synchronisation.clocks.coarse import Match, Speeds, speeds
from synchronisation.clocks.fine import ClockSolution, fit_cables
from synchronisation.clocks.signals import LogSignals, rewired
from synchronisation.clocks.undetermined import NoClue
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

ALIKE = 0.8
"""correlation below which log and video are not of one motion"""
CONTRADICTS = 0.6
"""correlation of one cable below which it is at odds with others above ALIKE"""
CERTAIN = 0.9
"""correlation that an exchange must bring before it is named"""
CLEARER = 0.03
"""by which it must lead over any other exchange"""
SUSPICIOUS = 1.2e-5
"""m that the cables must leave over before other arms are tried"""
HEALTHY = 3e-5
"""m that another arm may leave over to be taken for the true one"""
ENOUGH = 600
"""frames that tell arms apart"""
MUCH_LESS = 0.35
"""times what the described arm leaves over, and no more: with slow motion and friction of another kind others leave .4 and more"""
MOST_JOINTS = 4
"""up to which all orders of the angles are tried"""


def check_labels(arm: Arm, time: Array, alpha: Array, seen: Speeds, logged: Speeds, found: Match) -> None:
    """Refused, naming what to set right, where angles, cables or signs are exchanged, or a cable contradicts the others.

    time (F,), s, and alpha (F, N), rad, are the angles that `seen` was computed from.
    """
    moving = np.std(seen.values, axis=0) > 0.1 * np.std(seen.values, axis=0).max()
    low = np.flatnonzero(moving & (found.own < CONTRADICTS))
    if found.likeness >= ALIKE and not len(low):
        return
    words, score, rivals = _exchange(arm, time, alpha, logged)
    if score > CERTAIN and words:
        if rivals:
            raise Refused(
                "sync",
                f"log and video fit only with an exchange, but more than one would do: {words}, or {rivals[0]}",
                "check markers.on_bars, theta_sign and the order of the log's columns",
            )
        raise Refused("sync", f"log and video do not fit: {words}", "correct that, and synchronise again")
    _check_cables(found, moving)
    raise Refused(
        "sync",
        f"log and video do not show the same motion (best correlation of cable speeds {found.likeness:.2f})",
        "are they of the same recording, and do they overlap?",
    )


def _check_cables(found: Match, moving: NDArray[np.bool_]) -> None:
    """Refused where one cable contradicts what the others agree on."""
    for j in np.flatnonzero(moving):
        others = moving & (np.arange(len(moving)) != j)
        if others.sum() < 2 or found.own[j] > CONTRADICTS or np.any(found.own[others] < ALIKE):
            continue
        later = (
            f", but it does {found.elsewhere_shift[j]:+.2f} s away from them" if found.elsewhere[j] > CERTAIN else ""
        )
        raise Refused(
            "sync",
            f"cable {j + 1} contradicts all others: it does not follow its motor at the time that they agree on "
            f"(correlation {found.own[j]:.2f}, theirs {np.median(found.own[others]):.2f}{later})",
            f"check theta{j + 1} in the log (is it f{j + 1}?), its theta_sign and its route in neck.yaml",
        )


def check_alternatives(
    arm: Arm, signals: LogSignals, frames: Frames, starts: Sequence[float], law: CableTerms, fv: Array
) -> None:
    """Refused where an arm that is mirrored, or whose joints and cables are numbered otherwise, leaves much less over.

    Speeds of such an arm agree nearly as well with the log; only lengths tell, by the little that pulleys and the sides' common
    length add. Other arms are tried only where the described one leaves more over than a healthy one.
    """
    window = part_of(frames, slice(None, None, max(1, len(frames.time) // ENOUGH)))

    def left_by(one: Arm, signals: LogSignals, frames: Frames, law: CableTerms) -> float:
        """At best, from any of the offsets, m."""
        left = [np.inf]
        for start in starts:
            with suppress(NoClue):
                left.append(_left(fit_cables(one, signals, frames, start, fv, law)[0]))
        return min(left)

    # with dimensions as described: those of another arm would be taken for errors of them
    error = left_by(arm, signals, window, replace(law, drum=True))
    if error < SUSPICIOUS:
        return
    at = np.clip(window.time + starts[0], signals.time[0], signals.time[-1])
    moved = signals.travel(at) - signals.travel(at).mean(axis=0)
    orders = permutations(range(arm.N)) if arm.N <= MOST_JOINTS else [tuple(range(arm.N))]
    for order, sign in product(orders, (1, -1)):
        if sign > 0 and order == (*range(arm.N),):
            continue
        other = frames_of(arm, window.time, sign * window.alpha[:, list(order)], window.sigma, window.middle)
        predicted = other.winding - other.winding.mean(axis=0)
        size = np.sqrt(np.sum(predicted**2, axis=0))[:, None] * np.sqrt(np.sum(moved**2, axis=0))
        alike = sign * (predicted.T @ moved) / np.maximum(size, 1e-12)
        cables = linear_sum_assignment(-alike)[1]
        if np.mean(alike[np.arange(arm.M), cables]) < ALIKE:
            continue
        left = left_by(arm, rewired(arm, signals, cables.tolist(), sign), other, law)
        if left < min(MUCH_LESS * error, HEALTHY):
            words = (
                ["with all signs turned (a mirrored picture, and the other theta_sign for every motor)"]
                if sign < 0
                else []
            )
            if order != (*range(arm.N),):
                words.append(
                    f"with the angles in the order {', '.join(str(i + 1) for i in order)} and at once the log's columns in "
                    f"the order {', '.join(str(j + 1) for j in cables)}"
                )
            raise Refused(
                "sync",
                f"log and video fit better {' and '.join(words)}: {1e3 * left:.3f} mm are left unexplained "
                f"instead of {1e3 * error:.3f}",
                "check markers.on_bars, theta_sign and the order of the log's columns; this is not corrected by itself",
            )


def _left(fit: ClockSolution) -> float:
    """What no angles can explain of the cables' travels, RMS, m; of as many cables as joints, all that is left."""
    cables, joints = fit.residual.shape[1], len(fit.state.torque_error)
    return fit.state.model_error if cables > joints else float(np.sqrt(np.mean(fit.residual**2)))


def _exchange(arm: Arm, time: Array, alpha: Array, logged: Speeds) -> tuple[str, float, list[str]]:
    """The exchange that fits best in words ('' for none), its correlation, and others that fit as well."""
    n, m = arm.N, arm.M
    orders = list(permutations(range(n))) if n <= MOST_JOINTS else [tuple(range(n))]
    tried: list[tuple[float, int, str]] = []
    for order in orders:
        for signs in product((1, -1), repeat=n if n <= MOST_JOINTS else 0):
            turn = np.array(signs) if signs else np.ones(n)
            changed = alpha[:, list(order)] * turn
            seen = speeds(time, wound(arm, changed))
            score, cables = _assigned(seen.values, logged.values)
            words = [f"angles are in the order {', '.join(str(i + 1) for i in order)}"] if order != (*range(n),) else []
            if np.all(turn < 0):
                words.append("all theta run against the camera (theta_sign of every motor, or a mirrored picture)")
            else:
                words += [f"alpha{i + 1} has the wrong sign" for i in range(n) if turn[i] < 0]
            taken = [k for k, _ in cables]
            if taken != list(range(m)):
                away = [j for j in range(m) if taken[j] != j]
                pairs = len(away) == 2
                words.append(
                    f"theta{away[0] + 1} and theta{away[1] + 1} are swapped"
                    if pairs
                    else f"theta columns are in the order {', '.join(str(k + 1) for k in taken)}"
                )
            words += [
                f"theta{j + 1} runs against the camera (theta_sign of motors[{j}])"
                for j, (_, sign) in enumerate(cables)
                if sign < 0
            ]
            tried.append((score, len(words), "; ".join(words)))
    best = max(score for score, _, _ in tried)
    good = sorted((changes, -score, words) for score, changes, words in tried if score > best - CLEARER)
    fewest = [words for changes, _, words in good if changes == good[0][0]]
    return fewest[0], best, fewest[1:]


def _assigned(a: Array, b: Array) -> tuple[float, list[tuple[int, int]]]:
    """The best pairing of columns at one common lag: its mean correlation, and for each column of a (column of b, sign)."""
    size = np.sqrt(np.sum(a**2, axis=0))[:, None] * np.sqrt(np.sum(b**2, axis=0))
    every = np.stack([[correlate(q, p, method="fft") for q in b.T] for p in a.T]) / np.maximum(size, 1e-12)[..., None]
    # the lag where most columns find a partner
    lag = int(np.argmax(np.abs(every).max(axis=1).sum(axis=0)))
    table = every[:, :, lag]
    rows, columns = linear_sum_assignment(-np.abs(table))
    pairs = [(int(k), 1 if table[j, k] > 0 else -1) for j, k in zip(rows, columns, strict=True)]
    return float(np.mean(np.abs(table[rows, columns]))), pairs
