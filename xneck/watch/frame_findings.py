"""Frames that the stamps say are missing, and pictures that are shown again."""

from collections.abc import Sequence

import numpy as np

from vision.repeated_pictures import repeated_pictures
from xneck.watch.finding import Finding
from xneck.watch.video_watch import SeenFrame

MAX_LOST_IN_A_ROW = 2
"""frames that may be missing between two stamps: the motion between them is bridged (docs/thresholds.md)"""
LOST_SHARE_S, MAX_LOST_SHARE = 5.0, 0.05
"""s over which missing frames are counted, and the share of them that may be missing (docs/thresholds.md)"""
MAX_REPEATED = 1
"""frames of the newest LOST_SHARE_S that may repeat the one before (docs/thresholds.md)"""
_MIN_FRAMES = 10
_DO = "does the camera, or the program that records, keep up? Close other programs, or lower the frame rate"


def frame_findings(times: Sequence[float]) -> list[Finding]:
    """Frames that are missing between the stamps of the newest ones, s."""
    time = np.asarray(times)
    if len(time) < _MIN_FRAMES:
        return []
    steps = np.diff(time)
    period = float(np.median(steps))
    lost = np.maximum(np.rint(steps / period) - 1, 0)
    findings = []
    if len(rows := np.flatnonzero(lost > MAX_LOST_IN_A_ROW)):
        at = float(time[rows[-1]])
        what = f"{lost[rows[-1]]:.0f} frames are missing after {at:.2f} s"
        findings.append(Finding("lost_frames", at + period, "camera", what, _DO, f"{at:.3f} s"))
    last = time[:-1] >= time[-1] - LOST_SHARE_S
    lost[rows] = 0  # said by themselves
    count = float(lost[last].sum())
    if count > max(MAX_LOST_SHARE * (len(steps[last]) + count), MAX_LOST_IN_A_ROW):
        onset = float(time[:-1][last & (lost > 0)][0])
        what = f"{count:.0f} of the last {len(steps[last]) + count:.0f} frames are missing"
        findings.append(Finding("lost_frames", onset, "camera", what, _DO, "share"))
    return findings


def repetition_findings(frames: Sequence[SeenFrame]) -> list[Finding]:
    """Pictures among the newest that are shown again while the arm moves."""
    time = np.array([f.time for f in frames])
    repeated = repeated_pictures(time, np.stack([f.tracked.corners for f in frames]))
    if repeated.sum() <= MAX_REPEATED:
        return []
    at = float(time[repeated][0])
    what = f"{int(repeated.sum())} pictures of the last {time[-1] - time[0]:.0f} s are shown again while the arm moves"
    return [Finding("repeated_frames", at, "camera", what, _DO)]
