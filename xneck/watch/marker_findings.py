"""Markers that are out of sight, since when, and why as far as it shows."""

from collections.abc import Sequence

import numpy as np

from vision.frame_quality import CAUSES
from xneck.watch.finding import Finding
from xneck.watch.video_watch import SeenFrame

MIN_LOST_S = 0.4
"""s for which a marker must be out of sight before it is said: shorter gaps are bridged (docs/thresholds.md)"""


def marker_findings(frames: Sequence[SeenFrame], ids: Sequence[int], since: dict[int, float]) -> list[Finding]:
    """Markers that the newest frame does not show, and no frame of the last MIN_LOST_S.

    since: time, s, since when each marker that is out of sight has been so; is brought up to date with the newest frame."""
    newest = frames[-1]
    findings = []
    for k, marker in enumerate(ids):
        if not np.isnan(newest.tracked.corners[k]).any():
            since.pop(marker, None)
            continue
        begun = since.setdefault(marker, newest.time)
        if newest.time - begun < MIN_LOST_S:
            continue
        codes = [int(f.tracked.status[k]) for f in frames if f.time >= begun]
        cause = CAUSES.get(int(np.bincount(codes).argmax()), "not found")
        findings.append(
            Finding(
                kind="marker_lost",
                onset_s=begun,
                clock="camera",
                what=f"marker {marker} is {cause}",
                do="uncover it, light it, or move the camera",
                where=f"marker {marker} from {begun:.3f} s",
            )
        )
    return findings
