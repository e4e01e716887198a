"""Light by which markers are read badly: too much of it, too little, or flickering."""

from collections.abc import Sequence

import numpy as np

from xneck.watch.finding import Finding
from xneck.watch.video_watch import SeenFrame

MIN_LIGHT_S = 0.5
"""s for which light must be wrong before it is said (docs/thresholds.md)"""
CLIPPED_LEVEL, CLIPPED_SPREAD = 233.0, 1.0
"""grey level of a marker's white from which on it may be clipped, and between which levels all of it then lies: edges move outwards
(docs/thresholds.md)"""
MIN_CONTRAST = 40.0
"""grey levels between white and black of a marker, below which noise hides its edges (docs/thresholds.md)"""
FLICKER_S = 2.0
"""s over which flicker is judged (docs/thresholds.md)"""
MAX_FLICKER = 0.03
"""ratio to its mean of the RMS by which the markers' white changes from frame to frame (docs/thresholds.md)"""
_MIN_FRAMES = 8


def light_findings(frames: Sequence[SeenFrame]) -> list[Finding]:
    """What is wrong with the light of the newest frames."""
    newest = frames[-1].time
    last = [f for f in frames if f.time >= newest - FLICKER_S]
    findings = []
    for kind, wrong, what, do in (
        ("overexposed", _clipped, "the markers' white is clipped: overexposed", "less light, or a shorter exposure"),
        ("underexposed", _faint, "markers hardly stand out: underexposed", "more light, or a longer exposure"),
    ):
        onset = _since(last, [wrong(f) for f in last])
        if onset is not None and newest - onset >= MIN_LIGHT_S:
            findings.append(Finding(kind, onset, "camera", what, do))
    if (ripple := _flicker(last)) > MAX_FLICKER:
        what = f"the light flickers by {100 * ripple:.0f} % from frame to frame"
        do = "use lamps on direct current, or an exposure of whole periods of the mains"
        findings.append(Finding("flicker", last[0].time, "camera", what, do))
    return findings


def _clipped(frame: SeenFrame) -> bool:
    seen = np.isfinite(frame.white)
    if not seen.any():
        return frame.picture[0] >= CLIPPED_LEVEL
    clipped = (frame.white >= CLIPPED_LEVEL) & (frame.white - frame.bright <= CLIPPED_SPREAD)
    return bool(np.mean(clipped[seen]) >= 0.5)


def _faint(frame: SeenFrame) -> bool:
    contrast = (frame.white - frame.black)[np.isfinite(frame.white)]
    if len(contrast):
        return bool(np.median(contrast) < MIN_CONTRAST)
    dark, bright = frame.picture
    return bright - dark < MIN_CONTRAST and dark < CLIPPED_LEVEL


def _since(frames: Sequence[SeenFrame], wrong: Sequence[bool]) -> float | None:
    """Since when frames up to the newest are all wrong, s; None where it is not."""
    onset = None
    for frame, is_wrong in zip(reversed(frames), reversed(wrong), strict=True):
        if not is_wrong:
            break
        onset = frame.time
    return onset


def _flicker(frames: Sequence[SeenFrame]) -> float:
    """RMS change from frame to frame of the markers' white over its mean; what goes on for several frames is motion."""
    white = np.array([f.white for f in frames])
    if len(white) < _MIN_FRAMES:
        return 0.0
    seen = np.isfinite(white).all(axis=0)
    if not seen.any():
        return 0.0
    level = np.mean(white[:, seen] / white[:, seen].mean(axis=0), axis=1)
    # by the second difference, of which white noise has six times its own variance
    return float(np.sqrt(np.mean(np.diff(level, 2) ** 2) / 6))
