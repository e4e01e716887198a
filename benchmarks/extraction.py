"""Angles from the sample video: time and error beside OpenCV's refinements and AprilTag's detector, decoding alone as the limit."""

import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.apriltag import apriltags
from benchmarks.opencv import REFINEMENTS, Find, searching
from benchmarks.table import Claim, Table
from calibration.camera import Camera, camera_from
from mechanism.description import Neck, markers_of, read_neck
from mechanism.printed_markers import Markers
from samples.generator.camera import SAMPLE_CAMERA
from vision.linkage.linkage_fit import fit_linkage
from vision.markers.detection import MarkerDetector
from vision.markers.tracking import MarkerTracker, TrackingOptions
from vision.video import read_frames

SAMPLES = Path(__file__).parents[1] / "samples"
VIDEO = SAMPLES / "recording/video.mp4"
FRAMES = 240
EXPOSURE_S = 0.004
"""of the sample's shutter"""
PASSES = 4
DECODING, SUBPIX = "decoding alone", "OpenCV SUBPIX"
PYAPRILTAGS = "pyapriltags, decimate 2"
FOLLOWING = ("xneck, following", "xneck, following, template")
"""the second is what `xneck extract` does by default"""
OFTEN = (DECODING, *FOLLOWING, SUBPIX, PYAPRILTAGS)
"""rows of which the least of several passes counts; the slow ones take one"""

Seen = list[dict[int, NDArray[np.float64]]]


def measure() -> Table:
    """Ratios of time to decoding, and the angles' RMS error, on the first frames of the sample with its true camera."""
    neck = read_neck(SAMPLES / "recording/neck.yaml")
    markers = markers_of(neck, "neck.yaml")
    c = SAMPLE_CAMERA
    camera = camera_from(np.array([c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3]), (c.width, c.height))
    detector = MarkerDetector(markers)
    ways: dict[str, Find] = {
        "xneck, searching every frame": lambda grey: detector.detect(grey).corners,
    } | {f"OpenCV {name}": searching(markers.dictionary, name) for name in REFINEMENTS}
    theirs = apriltags(markers.dictionary, decimate=2.0)
    ways[PYAPRILTAGS] = lambda grey: dict(theirs(grey))
    options = {name: TrackingOptions(template=name.endswith("template"), exposure_s=EXPOSURE_S) for name in FOLLOWING}
    jobs: dict[str, Callable[[], Seen]] = {DECODING: lambda: [{} for _ in _frames()]}
    jobs |= {name: lambda tracking=tracking: list(_followed(markers, tracking)) for name, tracking in options.items()}
    jobs |= {name: lambda find=find: [find(grey) for grey in _frames()] for name, find in ways.items()}
    spent, seen = dict.fromkeys(jobs, np.inf), {}
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    for turn in range(PASSES):  # side by side, so that a busy machine is busy for all
        for name, job in jobs.items():
            if turn == 0 or name in OFTEN:
                begin = time.process_time()
                seen[name] = job()
                spent[name] = min(spent[name], time.process_time() - begin)
    cv2.setNumThreads(threads)
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    for name, cpu in spent.items():
        error, lost = (None, None) if name == DECODING else _error(neck, camera, seen[name])
        rows.append((name, (cpu / spent[DECODING], spent[SUBPIX] / cpu, error, lost)))
    columns = ("time / decoding", "frames/s over SUBPIX", "alpha rms deg", "angles lost")
    title = f"Extraction, {FRAMES} frames of the sample, processor time, least of passes"
    return Table(title, columns, tuple(rows), _claims(dict(rows)))


def _claims(figures: Mapping[str, tuple[float | None, ...]]) -> tuple[Claim, ...]:
    """Time and error of the same way, beside two peers."""
    limit, on = (DECODING, figures[DECODING][0]), f"{FRAMES} frames of the sample"
    peers = {name: figures[name] for name in (SUBPIX, PYAPRILTAGS)}
    claims: list[Claim] = []
    for way, words in zip(FOLLOWING, ("edges", "all grey levels"), strict=True):
        ours = figures[way]
        for peer, theirs in peers.items():
            time_of = f"time of a frame, corners from {words}, in decodings"
            claims.append(Claim(time_of, on, ours[0], (peer, theirs[0]), limit))
            claims.append(Claim(f"error of an angle, corners from {words}, rms, deg", on, ours[2], (peer, theirs[2])))
    return tuple(claims)


def _frames():  # type: ignore[no-untyped-def]
    for frame in read_frames(VIDEO):
        if frame.index == FRAMES:
            return
        yield frame.grey


def _followed(markers: Markers, tracking: TrackingOptions) -> Iterator[dict[int, NDArray[np.float64]]]:
    tracker = MarkerTracker(markers, tracking)
    for frame in read_frames(VIDEO):
        if frame.index == FRAMES:
            return
        yield dict(zip([m.id for m in markers.on_bars], tracker.track(frame).corners, strict=True))


def _error(neck: Neck, camera: Camera, seen: Seen) -> tuple[float, float]:
    """RMS over all joints and frames in degrees, and how many angles are missing."""
    order = [marker.id for marker in markers_of(neck, "neck.yaml").on_bars]
    hidden = np.full((4, 2), np.nan)
    corners = np.stack([np.stack([found.get(i, hidden) for i in order]) for found in seen])
    alpha = fit_linkage(neck, camera, corners, "benchmark").alpha
    truth = np.load(SAMPLES / "truth.npz")["recording_frame_alpha"][: len(alpha)]
    return float(np.degrees(np.sqrt(np.nanmean((alpha - truth) ** 2)))), float(np.isnan(alpha).sum())
