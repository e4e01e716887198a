"""Frames that a clock may be fitted to: within the log, clear of its gaps, and enough of them."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.clock_record import LostFrames
from synchronisation.clocks.coarse_alignment import MIN_OVERLAP_S
from synchronisation.clocks.frame_geometry import FrameGeometry
from synchronisation.clocks.log_gaps import RepairedLog
from synchronisation.clocks.signals import LogSignals
from synchronisation.clocks.undetermined import ClockUndetermined
from xneck_foundation.one_line import counted

Array = NDArray[np.float64]

EDGE_S = 0.75
"""s left out at both ends of log and video, where filters settle (docs/thresholds.md)"""
GAP_MARGIN_S = 0.1
"""s left out beside gaps of the log (docs/thresholds.md)"""
MIN_FRAMES = 30
"""frames with all angles that a clock needs (docs/thresholds.md)"""


def usable_frames(
    frames: FrameGeometry, signals: LogSignals, repaired: RepairedLog, lost: LostFrames, offset: float
) -> FrameGeometry:
    """The usable ones of frames given at their stamps, now at their true times, with the middle of those that are kept.

    offset: s, a rough one. Raises ClockUndetermined where log and video overlap too little."""
    true_time = lost.corrected(frames.time)
    usable = _inner(true_time + offset, signals.time) & _inner(true_time, true_time)
    overlap = _span(true_time[usable])
    if overlap < MIN_OVERLAP_S - 2 * EDGE_S:
        raise ClockUndetermined(
            "sync", f"log and video overlap by {overlap:.1f} s", f"record at least {MIN_OVERLAP_S:.0f} s of both"
        )
    within = int(usable.sum())
    usable &= repaired.clear_of_gaps(true_time + offset, GAP_MARGIN_S)
    if usable.sum() < MIN_FRAMES or _span(true_time[usable]) < MIN_OVERLAP_S - 2 * EDGE_S:
        raise ClockUndetermined(
            "sync",
            f"of {within} frames within the log {usable.sum()} are {GAP_MARGIN_S:g} s clear of its "
            f"{counted(len(repaired.gaps), 'gap')}, too few for a clock",
            "record more frames, or a log without pauses of 10 ms and more",
        )
    middle = float(true_time[usable][0] + true_time[usable][-1]) / 2
    return replace(frames, time=true_time, middle=middle).part(usable)


def _span(time: Array) -> float:
    """From the first to the last of times, s; zero of none."""
    return float(np.ptp(time)) if len(time) else 0.0


def _inner(time: Array, span: Array) -> NDArray[np.bool_]:
    """Which times are more than EDGE_S after the first and before the last of increasing times `span`, s."""
    return (time > span[0] + EDGE_S) & (time < span[-1] - EDGE_S)
