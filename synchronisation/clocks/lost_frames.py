"""Frames lost without a trace: stamps go on evenly, and every later frame is one period later than its stamp says.

The number of frames lost so far is decoded along the recording (Viterbi): a frame costs how badly its winding fits the log if it
was taken so late, and each loss costs as much as it is unlikely. The skew is fixed meanwhile, for a free one would explain slow
sequences of losses.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from identification.dataset.clock_record import FrameLoss, LostFrames
from synchronisation.clocks.frame_geometry import FrameGeometry
from synchronisation.clocks.gauss_newton_step import SKEW_SIGMA

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

LOSS_COST = 30.0
"""-2 log of the probability that a frame is missing; set high, so that noise alone feigns no loss (docs/thresholds.md)"""
NEXT_LOSS_COST = 6.0
"""-2 log of the probability of each further frame of one loss (docs/thresholds.md)"""
MIN_LOSS_EVIDENCE = 300.0
"""squared whitened motion by which a loss must show between it and the recording's end: a loss that is none is bought by what is
not known of cables at rest (docs/thresholds.md)"""
MAX_FRAMES_PER_LOSS = 4
"""frames that one loss may take at most (docs/thresholds.md)"""
MAX_FROM_CHEAPEST = 10
"""counts above and below the cheapest one that are followed at a time, as the cheapest may be mistaken for a while
(docs/thresholds.md)"""
MAX_FRAME_COST = 200.0
"""limit of one frame's cost, so that a wrong angle does not force a loss (docs/thresholds.md)"""
SKEW_WINDOW_S = 5.0
"""s: windows whose offsets give the skew in spite of losses between them"""
MIN_WINDOW_FRAMES = 30
"""frames that such a window needs"""
_MAX_WINDOW_STEP_S = 0.02
_CHUNK_FRAMES = 30
_IMPOSSIBLE = 1e9


def decode_lost_frames(
    frames: FrameGeometry,
    expected_winding: BSpline,
    clock: tuple[float, float],
    whitening: Array,
    period: float,
    reference: int,
) -> Counts:
    """How many frames were lost before each frame, counted from frame `reference` on, (F,); it never decreases.

    expected_winding: (..., M), m, over log time. clock: offset, s, and skew around the reference. whitening: (F, M, M).
    period: s, of the camera."""
    offset, skew = clock
    log_time = frames.time + offset + skew * (frames.time - frames.time[reference])
    costs = _FrameCosts(frames.winding, expected_winding, log_time, whitening, period)
    count = np.zeros(len(frames.time), dtype=np.int64)
    count[reference:] = _viterbi(costs, np.arange(reference, len(frames.time)), 1)
    count[: reference + 1] = _viterbi(costs, np.arange(reference, -1, -1), -1)[::-1]
    return _without_losses_at_rest(costs, count)


@dataclass(frozen=True)
class _FrameCosts:
    """What it costs to believe that frames were taken later than their stamps say."""

    winding: Array
    """(F, M), m"""
    expected_winding: BSpline
    log_time: Array
    """(F,), s, by the stamps"""
    whitening: Array
    period: float

    def of(self, part: Counts, counts: Counts) -> Array:
        """Squared whitened residuals of frames `part` (K,) at each of the counts (S,), limited; (K, S)."""
        at = self.log_time[part][:, None] + self.period * counts
        first, last = self.expected_winding.t[0], self.expected_winding.t[-1]
        residual = self.expected_winding(np.clip(at, first, last)) - self.winding[part][:, None, :]
        white = np.einsum("fij,fsj->fsi", self.whitening[part], residual)
        return np.minimum(np.sum(white**2, axis=-1), MAX_FRAME_COST)

    def between(self, part: Counts, counts: Counts, others: Counts) -> float:
        """Squared whitened difference that it makes for frames `part` (K,) whether they have some counts or others, (K,) each."""
        times = (self.log_time[part] + self.period * k for k in (counts, others))
        first, last = self.expected_winding.t[0], self.expected_winding.t[-1]
        windings, other_windings = (self.expected_winding(np.clip(at, first, last)) for at in times)
        white = np.einsum("fij,fj->fi", self.whitening[part], windings - other_windings)
        return float(np.sum(np.minimum(np.sum(white**2, axis=-1), MAX_FRAME_COST)))


def _viterbi(costs: _FrameCosts, order: Counts, sign: int) -> Counts:
    """The cheapest counts along `order` of frames, from 0 in steps of `sign`.

    The band of counts that are followed starts at `base` and moves with the cheapest one."""
    states = sign * np.arange(-MAX_FROM_CHEAPEST, MAX_FROM_CHEAPEST + 1)
    loss_cost = np.array([0.0, *(LOSS_COST + NEXT_LOSS_COST * k for k in range(MAX_FRAMES_PER_LOSS))])
    base, cost = 0, np.where(states == 0, 0.0, _IMPOSSIBLE)
    # by how much the band moved, and for each state how many were lost before it; the latter empty where the band moved
    history: list[tuple[int, Counts]] = []
    for begin in range(0, len(order), _CHUNK_FRAMES):
        part = order[begin : begin + _CHUNK_FRAMES]
        ahead = int(np.argmin(cost)) - MAX_FROM_CHEAPEST
        if ahead > 0:
            cost = np.concatenate([cost[ahead:], np.full(ahead, _IMPOSSIBLE)])
            history.append((ahead, np.zeros(0, dtype=np.int64)))
            base += sign * ahead
        for frame_cost in costs.of(part, base + states):
            paths = np.full((len(loss_cost), len(states)), _IMPOSSIBLE)
            for lost, extra in enumerate(loss_cost):
                paths[lost, lost:] = cost[: len(cost) - lost] + extra
            cheapest = np.argmin(paths, axis=0)
            cost = paths[cheapest, np.arange(len(states))] + frame_cost
            history.append((0, cheapest))
    counts = np.zeros(len(order), dtype=np.int64)
    state, k = int(np.argmin(cost)), len(order) - 1
    for ahead, cheapest in reversed(history):
        if not len(cheapest):
            state += ahead
            base -= sign * ahead
            continue
        counts[k] = base + states[state]
        state -= int(cheapest[state])
        k -= 1
    return counts - counts[0]


def _without_losses_at_rest(costs: _FrameCosts, count: Counts) -> Counts:
    """The counts (F,) without losses between which and the recording's end the arm hardly moves.

    An arm at rest looks the same a frame later, and what cables do at rest is not known well enough to tell."""
    count = count.copy()
    while len(steps := np.flatnonzero(np.diff(count))):
        first, last = int(steps[0]) + 1, int(steps[-1]) + 1
        before, after = np.arange(first), np.arange(last, len(count))
        lost_first, lost_last = count[first] - count[first - 1], count[last] - count[last - 1]
        if costs.between(before, count[before], count[before] + lost_first) < MIN_LOSS_EVIDENCE:
            count[before] += lost_first
        elif costs.between(after, count[after], count[after] - lost_last) < MIN_LOSS_EVIDENCE:
            count[after] -= lost_last
        else:
            break
    return count


def skew_despite_losses(
    frames: FrameGeometry, expected_winding: BSpline, offset: float, whitening: Array, reference: int
) -> float:
    """The skew that most windows agree on, whatever was lost between some of them; `offset`, s, holds around frame `reference`."""
    edges = np.arange(frames.time[0], frames.time[-1], SKEW_WINDOW_S)
    middle = int(np.searchsorted(edges, frames.time[reference])) - 1
    first, last = expected_winding.t[0], expected_winding.t[-1]
    offsets = np.full(len(edges), np.nan)
    for windows in (range(middle, len(edges)), range(middle - 1, -1, -1)):
        shift = offset if np.isnan(offsets[middle]) else offsets[middle]
        for w in windows:
            part = slice(*np.searchsorted(frames.time, [edges[w], edges[w] + SKEW_WINDOW_S]))
            if part.stop - part.start < MIN_WINDOW_FRAMES:
                continue
            for _ in range(4):
                at = np.clip(frames.time[part] + shift, first, last)
                residual = np.einsum("fij,fj->fi", whitening[part], expected_winding(at) - frames.winding[part])
                slope = np.einsum("fij,fj->fi", whitening[part], expected_winding(at, 1))
                step = np.sum(residual * slope) / max(np.sum(slope**2), 1e-30)
                shift -= float(np.clip(step, -_MAX_WINDOW_STEP_S, _MAX_WINDOW_STEP_S))
            offsets[w] = shift
    rate = np.diff(offsets) / SKEW_WINDOW_S
    rate = rate[np.isfinite(rate)]
    skew = float(np.median(rate)) if len(rate) > 3 else 0.0
    return skew if abs(skew) < SKEW_SIGMA else 0.0


def lost_frames_of(time: Array, count: Counts, period: float) -> LostFrames:
    """The losses in counts (F,) of frames lost before frames stamped `time` (F,), s; period: s, of the camera."""
    steps = np.diff(count)
    losses = tuple(FrameLoss(float(time[k + 1]), int(steps[k])) for k in np.flatnonzero(steps))
    return LostFrames(losses, period)
