"""Woven fields are told from whole pictures by the markers in motion, in noise, coded coarsely, and with a rolling shutter."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.vision.markers.test_tracking import VIDEO, film, markers, truth
from vision.interlacing import MAX_SHARE_SIGMA, MIN_SHARE, refuse_interlaced, row_shift, share_of_motion
from vision.marker_tracks import TracksOptions, track_markers
from vision.markers.tracking import MarkerTracker
from vision.markers.video_tracking import tracks_of
from vision.video import Frame, describe_video
from xneck_foundation.errors import Refused

RATE_HZ, FRAMES, SWING_PX = 30.0, 60, 12.0
TIME = np.arange(FRAMES) / RATE_HZ


def place(time: np.ndarray | float) -> np.ndarray:
    """Where the picture has moved to, px: along both axes, at its own rate each."""
    return SWING_PX * np.stack([np.sin(6.1 * np.asarray(time)), np.cos(4.7 * np.asarray(time))], axis=-1)


def still() -> tuple[np.ndarray, np.ndarray]:
    """The part of the sample's first frame that shows the upper two markers, and their corners."""
    corners = truth()[0, 2:]
    x0, y0 = np.floor(corners.min(axis=(0, 1)) - 40).astype(int)
    x1, y1 = np.ceil(corners.max(axis=(0, 1)) + 40).astype(int)
    return film()[0].grey[y0:y1, x0:x1], corners - (x0, y0)


def moved(time: float, row_s: float) -> np.ndarray:
    """This part moved to where it is at a time; the row below is exposed by `row_s` later."""
    grey = still()[0]
    dx, dy = place(time)
    along = float((place(time + 1e-3) - place(time - 1e-3))[0]) / 2e-3 * row_s
    shear = np.array([[1.0, along, dx - along * grey.shape[0] / 2], [0.0, 1.0, dy]])
    return cv2.warpAffine(grey, shear, grey.shape[::-1], flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


def share(fields_apart: float, noise: float, quality: int | None, row_s: float, seed: int) -> tuple[float, float]:
    """What is found where odd rows are so many frames ahead of even ones."""
    rng = np.random.default_rng(seed)
    corners = still()[1] + place(TIME)[:, None, None]
    shift = np.empty(corners.shape[:2])
    for k, time in enumerate(TIME.tolist()):
        grey = moved(time, row_s).copy()
        grey[1::2] = moved(time + fields_apart / RATE_HZ, row_s)[1::2]
        grey = np.clip(grey + rng.normal(0, noise, grey.shape), 0, 255).astype(np.uint8) if noise else grey
        if quality is not None:
            coded = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
            grey = np.asarray(cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE), dtype=np.uint8)
        shift[k] = row_shift(grey, corners[k])
    return share_of_motion(TIME, corners, shift)


@pytest.mark.parametrize(("noise", "quality", "row_s"), [(0.0, None, 0.0), (20.0, None, 0.0), (3.0, 25, 1e-4)])
def test_whole_pictures_are_told_from_woven_ones(noise: float, quality: int | None, row_s: float) -> None:
    whole, sigma = share(0.0, noise, quality, row_s, seed=1)
    assert abs(whole) < MIN_SHARE / 2
    assert sigma < MAX_SHARE_SIGMA
    for fields_apart in (0.5, -0.5):
        woven, _ = share(fields_apart, noise, quality, row_s, seed=2)
        assert np.sign(fields_apart) * woven > 1.5 * MIN_SHARE


def test_a_film_of_two_moments_a_picture_is_refused_with_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows of every second frame of the sample, and between them those of the frame after it."""
    tracker, seen = MarkerTracker(markers()), []
    for even, odd in zip(film()[::2], film()[1::2], strict=True):
        grey = even.grey.copy()
        grey[1::2] = odd.grey[1::2]
        seen.append(tracker.track(Frame(even.index, even.time, grey)))
    woven = tracks_of(seen, None)
    monkeypatch.setattr("vision.marker_tracks.track_video", lambda *args: woven)
    monkeypatch.setattr("vision.marker_tracks._ids_in_view", lambda *args: (0, 1, 2, 3))
    video = replace(describe_video(VIDEO), path=Path("lab/cam.mp4"))
    with pytest.raises(Refused, match=r"cam.mp4: is interlaced: .*; give every field .*ffmpeg -i cam.mp4 -vf bwdif"):
        track_markers(video, TracksOptions("apriltag_36h11", template=False))


def test_the_same_film_whole_is_not_refused() -> None:
    tracker = MarkerTracker(markers())
    whole = tracks_of([tracker.track(frame) for frame in film()[:60]], None)
    refuse_interlaced(Path("a.mp4"), whole.time, whole.corners, whole.row_shift)
    assert abs(share_of_motion(whole.time, whole.corners, whole.row_shift)[0]) < MIN_SHARE / 5


def test_what_does_not_move_tells_nothing() -> None:
    rng, at_rest = np.random.default_rng(0), np.broadcast_to(truth()[0], (5, *truth()[0].shape))
    noise = rng.normal(0, 0.3, at_rest.shape[:2])
    assert np.isnan(share_of_motion(TIME[:5], at_rest, noise)[0])
    refuse_interlaced(Path("a.mp4"), TIME[:5], at_rest, noise)
    refuse_interlaced(Path("a.mp4"), TIME[:5], at_rest + rng.normal(0, 0.02, at_rest.shape), noise)
    assert np.isnan(row_shift(film()[0].grey, np.full((1, 4, 2), np.nan))).all()
