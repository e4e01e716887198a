"""Which dictionary the markers in a video were printed from, where they are not of the one that was named."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.dictionaries import dictionary_names, dictionary_size
from mechanism.printed_markers import BarMarker, Markers
from vision.markers.detection import MarkerDetector
from vision.video import Video, read_segments
from xneck_foundation.errors import Refused

_LOOKED_AT = 3
"""frames, spread over the video"""
_MIN_SIGHTINGS = 3
"""of one dictionary's markers in these frames: one or two are read by chance (docs/thresholds.md)"""
_ANY_SIZE = 0.02


@dataclass(frozen=True)
class DictionaryInView:
    """A dictionary whose markers a video shows, though not those that were looked for."""

    name: str
    mirrored: bool
    """whether they are seen in the mirrored picture alone"""


def dictionary_in_view(video: Video) -> DictionaryInView | None:
    """The dictionary of which most markers are seen, the smallest of those that contain one another; None where none is sure.

    Where none is, the pictures are looked at in a mirror."""
    every = max(1, video.frames // _LOOKED_AT)
    frames = [frame.grey.copy() for frame in read_segments(video) if frame.index % every == 0]
    if name := _most_seen(frames):
        return DictionaryInView(name, mirrored=False)
    if name := _most_seen([np.ascontiguousarray(grey[:, ::-1]) for grey in frames]):
        return DictionaryInView(name, mirrored=True)
    return None


def refuse_mirrored(path: Path, view: DictionaryInView | None) -> None:
    """Refused where markers are seen in a mirror alone."""
    if view and view.mirrored:
        what = f"its picture is mirrored: markers of {view.name} are seen only with left and right exchanged"
        raise Refused(path, what, "switch mirroring off in the camera or its program, or mirror the video back")


def _most_seen(frames: Sequence[NDArray[np.uint8]]) -> str | None:
    sightings = Counter[str]()
    for name in sorted(dictionary_names(), key=dictionary_size):
        detector = MarkerDetector(Markers(dictionary=name, size=_ANY_SIZE, on_bars=(BarMarker(id=0, bar=0),)))
        sightings[name] = sum(len(detector.detect_all(grey)) for grey in frames)
    name, count = sightings.most_common(1)[0]
    return name if count >= _MIN_SIGHTINGS else None
