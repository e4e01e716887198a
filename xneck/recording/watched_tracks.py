"""Marker tracks that `xneck watch` made of a video while it grew, kept so that `run` need not read these frames again.

They are used only where everything that they depend on is what it was: the video's bytes, the markers, how they are followed, and
the software. Each segment is one that `run` would track by itself, so that the result is the same to the last bit.
"""

import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mechanism.description import Neck, markers_of
from vision.extract import ExtractionOptions
from vision.markers.video_tracking import MarkerTracks
from vision.video import Segment, Video
from xneck.recording.software_versions import software_versions
from xneck_foundation.authorship import written_by_xneck
from xneck_foundation.provenance import sha256
from xneck_foundation.whole_file import whole_file

_ABOUT = "about"
_ARRAYS = (
    "time",
    "corners",
    "covariance",
    "status",
    "hidden",
    "clipped",
    "fell_back",
    "row_shift",
    "prints",
    "foreign_ids",
    "light",
)
_SEGMENT_FIELDS = ("first_index", "count", "first_stamp", "end_stamp")


def write_watched_tracks(
    path: Path, video: Path, neck: Neck, options: ExtractionOptions, tracked: Mapping[Segment, MarkerTracks]
) -> None:
    """Writes the tracks of segments of a finished video."""
    about = _made_from(video, neck, options) | {
        "segments": [[getattr(segment, name) for name in _SEGMENT_FIELDS] for segment in tracked]
    }
    arrays = {
        f"{k}/{name}": np.asarray(value)
        for k, tracks in enumerate(tracked.values())
        for name in _ARRAYS
        if (value := getattr(tracks, name)) is not None
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as part, part.open("wb") as stream:
        np.savez(stream, allow_pickle=False, **{_ABOUT: np.array(json.dumps(about)), **arrays})


def read_watched_tracks(
    path: Path | None, video: Video, neck: Neck, options: ExtractionOptions
) -> dict[Segment, MarkerTracks]:
    """The tracks in a file, by segment; none where there is no such file, or anything that they depend on has changed."""
    if path is None or not path.is_file() or not written_by_xneck(path):
        return {}
    try:
        with np.load(path, allow_pickle=False) as stored:
            about = json.loads(str(stored[_ABOUT]))
            made_from = _made_from(video.path, neck, options)
            if {key: about.get(key) for key in made_from} != made_from:
                return {}
            segments = [Segment(**dict(zip(_SEGMENT_FIELDS, values, strict=True))) for values in about["segments"]]
            arrays = [{n: stored[f"{k}/{n}"] for n in _ARRAYS if f"{k}/{n}" in stored} for k in range(len(segments))]
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile):  # a damaged file is as good as none
        return {}
    return {segment: _tracks(of) for segment, of in zip(segments, arrays, strict=True)}


def _tracks(arrays: dict[str, Any]) -> MarkerTracks:
    ids = tuple(arrays.pop("foreign_ids").tolist())
    return MarkerTracks(**{"covariance": None, **arrays}, foreign_ids=ids)


def _made_from(video: Path, neck: Neck, options: ExtractionOptions) -> dict[str, Any]:
    """All that tracks depend on, ready for JSON."""
    about = {
        "video_sha256": sha256(video),
        "markers": markers_of(neck, "neck.yaml").model_dump(mode="json"),
        "tracking": repr(options.tracking),
        "light": repr(options.light),
        "software": software_versions(),
    }
    return json.loads(json.dumps(about))
