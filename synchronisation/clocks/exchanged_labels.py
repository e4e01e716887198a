"""Signs and labels: which exchange of angles, cables or signs would make log and video show the same motion.

Nothing is corrected in silence: the exchange is named, so that the file that states it can be set right.
"""

from collections.abc import Iterator
from itertools import permutations, product
from typing import Never

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.signal import correlate

from mechanism.arm import Arm
from synchronisation.clocks.coarse_alignment import (
    MIN_OVERLAP_S,
    SPEED_RATE_HZ,
    CableSpeeds,
    CoarseAlignment,
    cable_speeds,
)
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.swapped_order import order_words
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed

Array = NDArray[np.float64]

MIN_CORRELATION = 0.8
"""correlation below which log and video are not of one motion (docs/thresholds.md)"""
FAINT_CORRELATION = 0.5
"""correlation from which on they may be, and something else hides it (docs/thresholds.md)"""
MIN_CABLE_CORRELATION = 0.6
"""correlation of one cable below which it contradicts others that correlate by MIN_CORRELATION (docs/thresholds.md)"""
EXCHANGE_CORRELATION = 0.9
"""correlation that an exchange must bring before it is named (docs/thresholds.md)"""
MIN_LEAD = 0.03
"""difference of correlation by which an exchange must lead over another to exclude it (docs/thresholds.md)"""
MIN_OVERLAP_SHARE = 0.5
"""of the shorter one of log and video, that an exchange is sought in (docs/thresholds.md)"""
MAX_PERMUTED_JOINTS = 4
"""number of joints up to which all orders and signs of the angles are tried (docs/thresholds.md)"""
MOVING_SHARE = 0.1
"""a cable moves if its speed's standard deviation is more than this share of the fastest one's (docs/thresholds.md)"""

ALL_AGAINST = "all theta run against the camera (theta_sign of every motor, or a mirrored picture)"


def check_labels(
    arm: Arm, time: Array, alpha: Array, video: CableSpeeds, log: CableSpeeds, alignment: CoarseAlignment
) -> None:
    """Refused, naming what to set right, where angles, cables or signs are exchanged, or a cable contradicts the others.

    time (F,), s, and alpha (F, N), rad, are the angles that the speeds of the video were computed from.
    """
    # a log may hold a stretch in which some cables rest
    within = video.rows((log.first - alignment.shift, log.last - alignment.shift))
    speed = np.std(video.values[within] if within.stop - within.start > 1 else video.values, axis=0)
    moving = speed > MOVING_SHARE * speed.max()
    contradicting = np.any(moving & (alignment.cable_correlation < MIN_CABLE_CORRELATION))
    if alignment.correlation >= MIN_CORRELATION and not contradicting:
        return
    words, correlation, rivals = _best_exchange(arm, time, alpha, log)
    if correlation > EXCHANGE_CORRELATION and words:
        if rivals:
            raise Refused(
                "sync",
                f"log and video fit only with an exchange, but more than one would do: {words}, or {rivals[0]}",
                "check markers.on_bars, theta_sign and the order of the log's columns",
            )
        reorders = "theta" in words and ("are swapped" in words or "another order" in words)
        forces = " (f too, where motors are exchanged and not theta alone)" if reorders else ""
        raise Refused("sync", f"log and video do not fit: {words}", f"correct that{forces}, and synchronise again")
    _check_cables(alignment, moving)
    if alignment.correlation >= MIN_CORRELATION:
        _refuse_loose_cables(alignment, moving)
    what = f"log and video do not show the same motion (best correlation of cable speeds {alignment.correlation:.2f})"
    remedy = "are they of the same recording, and do they overlap?"
    if alignment.correlation > FAINT_CORRELATION:
        what = (
            f"log and video hardly show the same motion (best correlation of cable speeds {alignment.correlation:.2f})"
        )
        remedy += " If so, cables stretch as far as they wind, or R and rd are not the motors': record a larger motion"
    raise Refused("sync", what, remedy)


def _refuse_loose_cables(alignment: CoarseAlignment, moving: NDArray[np.bool_]) -> Never:
    """Where log and video show one motion, and not all cables follow it: which, and what may be."""
    correlation = alignment.cable_correlation
    loose = np.flatnonzero(moving & (correlation < MIN_CABLE_CORRELATION))
    least, of_all = correlation[loose].min(), alignment.correlation
    what = f"hardly {'follow their motors' if len(loose) > 1 else 'follows its motor'}"
    raise Refused(
        "sync",
        f"{listed([f'cable {j + 1}' for j in loose])} {what} (correlation {least:.2f}, of all together {of_all:.2f})",
        "a cable that stretches as far as it winds needs a larger motion; else check its route, R and rd in neck.yaml",
    )


def _check_cables(alignment: CoarseAlignment, moving: NDArray[np.bool_]) -> None:
    """Refused where one cable contradicts what the others agree on."""
    correlation = alignment.cable_correlation
    for j in np.flatnonzero(moving):
        others = moving & (np.arange(len(moving)) != j)
        agreed = others.sum() >= 2 and not np.any(correlation[others] < MIN_CORRELATION)
        if not agreed or correlation[j] > MIN_CABLE_CORRELATION:
            continue
        later = ""
        if alignment.cable_peak[j] > EXCHANGE_CORRELATION:
            later = f", but it does {alignment.cable_peak_shift[j]:+.2f} s away from them"
        raise Refused(
            "sync",
            f"cable {j + 1} contradicts all others: it does not follow its motor at the time that they agree on "
            f"(correlation {correlation[j]:.2f}, theirs {np.median(correlation[others]):.2f}{later})",
            f"check theta{j + 1} in the log (is it f{j + 1}?), its theta_sign and its route in neck.yaml; "
            "or, where it stretches as far as it winds, record a larger motion",
        )


def _best_exchange(arm: Arm, time: Array, alpha: Array, log: CableSpeeds) -> tuple[str, float, list[str]]:
    """The exchange that correlates best in words ('' for none), its correlation, and others that do as well.

    Of exchanges within MIN_LEAD of the best correlation those with the fewest changes count."""
    tried: list[tuple[float, int, str]] = []
    for order, signs in _angle_exchanges(arm.N):
        video = cable_speeds(time, cable_winding(arm, alpha[:, list(order)] * signs))
        for correlation, pairs in _pairings(video.values, log.values):
            words = exchange_words(order, signs, pairs)
            tried.append((correlation, len(words), "; ".join(words)))
    best = max(correlation for correlation, _, _ in tried)
    good = sorted(
        (changes, -correlation, words) for correlation, changes, words in tried if correlation > best - MIN_LEAD
    )
    fewest = list(dict.fromkeys(words for changes, _, words in good if changes == good[0][0]))
    return fewest[0], best, fewest[1:]


def _angle_exchanges(n: int) -> Iterator[tuple[tuple[int, ...], Array]]:
    """Orders and signs (n,) of the angles that are tried; with many joints the given ones only."""
    few = n <= MAX_PERMUTED_JOINTS
    for order in permutations(range(n)) if few else [tuple(range(n))]:
        for signs in product((1, -1), repeat=n) if few else [(1,) * n]:
            yield order, np.array(signs)


def _pairings(a: Array, b: Array) -> Iterator[tuple[float, list[tuple[int, int]]]]:
    """The best pairing of columns at one common lag, and that of each column with its own: the mean correlation, and for each
    column of a (column of b, sign).

    Cables that are each other's mirror images run against each other, all but alike: that they are swapped, and that both run
    the other way, explain the same log nearly as well.
    """
    every = np.stack([[correlate(q, p, method="fft") for q in b.T] for p in a.T])
    # a log may hold a part of the video, or the video a part of the log
    energy_a = np.stack([correlate(np.ones(len(b)), p, method="fft") for p in a.T**2])
    energy_b = np.stack([correlate(q, np.ones(len(a)), method="fft") for q in b.T**2])
    overlap = correlate(np.ones(len(b)), np.ones(len(a)), method="fft")
    enough = overlap > max(MIN_OVERLAP_S * SPEED_RATE_HZ, MIN_OVERLAP_SHARE * min(len(a), len(b)))
    size = np.sqrt(np.maximum(energy_a[:, None] * energy_b, 0.0))
    every = np.where(enough, every / np.maximum(size, 1e-12), 0.0)
    # the lag at which most columns have a partner
    table = every[:, :, int(np.argmax(np.abs(every).max(axis=1).sum(axis=0)))]
    yield _paired(table, *linear_sum_assignment(-np.abs(table)))
    own = np.abs(every[np.arange(len(every)), np.arange(len(every))])
    table = every[:, :, int(np.argmax(own.sum(axis=0)))]
    yield _paired(table, np.arange(len(every)), np.arange(len(every)))


def _paired(table: Array, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> tuple[float, list[tuple[int, int]]]:
    pairs = [(int(k), 1 if table[j, k] > 0 else -1) for j, k in zip(rows, columns, strict=True)]
    return float(np.mean(np.abs(table[rows, columns]))), pairs


def exchange_words(order: tuple[int, ...], signs: Array, pairs: list[tuple[int, int]]) -> list[str]:
    """What an exchange of angles and a pairing of cables changes, a clause each."""
    n, columns = len(order), [k for k, _ in pairs]
    words = [f"angles are in the order {', '.join(str(i + 1) for i in order)}"] if order != (*range(n),) else []
    if np.all(signs < 0):
        words.append(ALL_AGAINST)
    else:
        words += [f"alpha{i + 1} has the wrong sign" for i in range(n) if signs[i] < 0]
    if reordered := order_words("theta", columns):
        words.append(reordered)
    against = [j for j, (_, sign) in enumerate(pairs) if sign < 0]
    if len(against) == len(pairs) > 1 and not np.all(signs < 0):
        return [*words, ALL_AGAINST]
    return words + [f"theta{j + 1} runs against the camera (theta_sign of motors[{j}])" for j in against]
