"""Frames lost without a trace: the stamps go on evenly, and every later frame is one period later than its stamp says.

The number of lost frames so far is decoded along the recording (Viterbi): a frame costs how badly its cables fit the log at
that lateness, and each further loss costs as much as it is unlikely. The skew is locked meanwhile, for a free one would take
slow sequences of losses for itself.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from identification.dataset.clock_record import Slip, Slips
from synchronisation.clocks.cables import Frames
from synchronisation.clocks.newton_step import LIKELY_SKEW

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

LOSS = 30.0
"""-2 log of how likely a frame is to be missing, generously: noise alone must not feign a loss"""
FURTHER = 6.0
"""the same for each further frame of one loss"""
REACH = 4
"""losses in turn that are thought of"""
BAND = 10
"""counts on each side of the present one that are followed"""
WORST = 200.0
"""a frame's cost is capped here, so that a wrong angle does not force a loss"""
WINDOW = 5.0
"""s over which an offset is taken to find the skew"""


def decode(frames: Frames, curve: BSpline, offset: float, skew: float, whiten: Array, period: float, at: int) -> Whole:
    """How many frames were lost before each frame, counted from frame `at`, (F,); non-decreasing.

    curve: travel less elongation over log time, (..., M), m. offset and skew: the clock around frame `at`.
    """
    count = np.zeros(len(frames.time), dtype=np.int64)
    log_time = frames.time + offset + skew * (frames.time - frames.time[at])
    count[at:] = _run(frames, curve, log_time, whiten, period, np.arange(at, len(frames.time)), 1)
    count[: at + 1] = _run(frames, curve, log_time, whiten, period, np.arange(at, -1, -1), -1)[::-1]
    return count


def _run(
    frames: Frames, curve: BSpline, log_time: Array, whiten: Array, period: float, order: Whole, sign: int
) -> Whole:
    """Counts along `order` of frames, from 0 in steps of `sign`; the band of states moves with the best one."""
    states = sign * np.arange(-2, BAND + 1)  # relative to the band's base; a few back, as the best may be mistaken
    jump = np.array([0.0, *(LOSS + FURTHER * k for k in range(REACH))])
    base, cost = 0, np.where(states == 0, 0.0, 1e9)
    first, last = curve.t[0], curve.t[-1]
    back: list[tuple[int, Whole]] = []
    chunk = 30
    for begin in range(0, len(order), chunk):
        part = order[begin : begin + chunk]
        best = int(np.argmin(cost)) - 2
        if best > 0:  # carry the band along
            cost = np.concatenate([cost[best:], np.full(best, 1e9)])
            back.append((best, np.zeros(0, dtype=np.int64)))
            base += sign * best
        at = log_time[part][:, None] + period * (base + states)
        left = curve(np.clip(at, first, last)) - frames.winding[part][:, None, :]
        white = np.einsum("fij,fsj->fsi", whiten[part], left)
        fits = np.minimum(np.sum(white**2, axis=-1), WORST)
        for row in fits:
            ways = np.full((len(jump), len(states)), 1e9)
            for k, extra in enumerate(jump):
                ways[k, k:] = cost[: len(cost) - k] + extra
            taken = np.argmin(ways, axis=0)
            cost = ways[taken, np.arange(len(states))] + row
            back.append((0, taken))
    out = np.zeros(len(order), dtype=np.int64)
    state, k = int(np.argmin(cost)), len(order) - 1
    for shift, taken in reversed(back):
        if not len(taken):
            state += shift
            base -= sign * shift
            continue
        out[k] = base + states[state]
        state -= int(taken[state])
        k -= 1
    return out - out[0]


def locked_skew(frames: Frames, curve: BSpline, offset: float, whiten: Array, at: int) -> float:
    """The skew that most windows agree on, whatever jumps lie between some of them; `offset` holds around frame `at`."""
    edges = np.arange(frames.time[0], frames.time[-1], WINDOW)
    middle = int(np.searchsorted(edges, frames.time[at])) - 1
    offsets = np.full(len(edges), np.nan)
    for order in (range(middle, len(edges)), range(middle - 1, -1, -1)):
        shift = offset if np.isnan(offsets[middle]) else offsets[middle]
        for w in order:
            part = slice(*np.searchsorted(frames.time, [edges[w], edges[w] + WINDOW]))
            if part.stop - part.start < 30:
                continue
            for _ in range(4):
                at_log = np.clip(frames.time[part] + shift, curve.t[0], curve.t[-1])
                left = np.einsum("fij,fj->fi", whiten[part], curve(at_log) - frames.winding[part])
                slope = np.einsum("fij,fj->fi", whiten[part], curve(at_log, 1))
                shift -= float(np.clip(np.sum(left * slope) / max(np.sum(slope**2), 1e-30), -0.02, 0.02))
            offsets[w] = shift
    rate = np.diff(offsets) / WINDOW
    rate = rate[np.isfinite(rate)]
    skew = float(np.median(rate)) if len(rate) > 3 else 0.0
    return skew if abs(skew) < LIKELY_SKEW else 0.0


def slips_of(time: Array, count: Whole, period: float) -> Slips:
    """The losses in a sequence of counts (F,) for frames stamped `time` (F,), s."""
    steps = np.diff(count)
    found = tuple(Slip(float(time[k + 1]), int(steps[k])) for k in np.flatnonzero(steps))
    return Slips(found, period)
