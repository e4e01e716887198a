"""Angles from the sample video: time and error beside OpenCV's refinements, decoding alone as the limit."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.opencv import REFINEMENTS, Find, searching
from benchmarks.table import Table
from calibration.camera import Camera, camera_from
from mechanism.description import Markers, Neck, markers_of, read_neck
from samples.generator.camera import SAMPLE_CAMERA
from vision.linkage_fit import fit_linkage
from vision.markers import Finder
from vision.tracking import Tracker
from vision.video import frames

SAMPLES = Path(__file__).parents[1] / "samples"
VIDEO = SAMPLES / "recording/video.mp4"
FRAMES = 240


def measure() -> Table:
    """Ratios of time to decoding, and the angles' RMS error, on the first frames of the sample with its true camera."""
    neck = read_neck(SAMPLES / "recording/neck.yaml")
    markers = markers_of(neck, "neck.yaml")
    c = SAMPLE_CAMERA
    camera = camera_from(np.array([c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3]), (c.width, c.height))
    finder = Finder(markers)
    ways: dict[str, Find] = {
        "xneck, searching every frame": lambda grey: finder.find(grey).corners,
    } | {f"OpenCV {name}": searching(markers.dictionary, name) for name in REFINEMENTS}
    decode = _seconds(lambda: [None for _ in _frames()])
    rows: list[tuple[str, tuple[float | None, ...]]] = [("decoding alone", (1.0, None, None))]
    for name, find in ways.items():
        seen: list[dict[int, NDArray[np.float64]]] = []
        spent = _seconds(lambda find=find, seen=seen: seen.extend(find(grey) for grey in _frames()))
        error, lost = _error(neck, camera, seen)
        rows.append((name, (spent / decode, error, lost)))
    followed: list[dict[int, NDArray[np.float64]]] = []
    spent = _seconds(lambda: followed.extend(_followed(markers)))
    error, lost = _error(neck, camera, followed)
    rows.insert(1, ("xneck, following", (spent / decode, error, lost)))
    columns = ("time / decoding", "alpha rms deg", "angles lost")
    return Table(f"Extraction, {FRAMES} frames of the sample, one pass each", columns, tuple(rows))


def _frames():  # type: ignore[no-untyped-def]
    for frame in frames(VIDEO):
        if frame.index == FRAMES:
            return
        yield frame.grey


def _followed(markers: Markers) -> Iterator[dict[int, NDArray[np.float64]]]:
    tracker = Tracker(markers)
    for frame in frames(VIDEO):
        if frame.index == FRAMES:
            return
        yield dict(zip([m.id for m in markers.on_bars], tracker.see(frame).corners, strict=True))


def _error(neck: Neck, camera: Camera, seen: list[dict[int, NDArray[np.float64]]]) -> tuple[float, float]:
    """RMS over all joints and frames in degrees, and how many angles are missing."""
    order = [marker.id for marker in markers_of(neck, "neck.yaml").on_bars]
    hidden = np.full((4, 2), np.nan)
    corners = np.stack([np.stack([found.get(i, hidden) for i in order]) for found in seen])
    alpha = fit_linkage(neck, camera, corners, "benchmark").alpha
    truth = np.load(SAMPLES / "truth.npz")["recording_frame_alpha"][: len(alpha)]
    return float(np.degrees(np.sqrt(np.nanmean((alpha - truth) ** 2)))), float(np.isnan(alpha).sum())


def _seconds(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin
