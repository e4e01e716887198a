"""Markers are followed where they are, lost where they are not, and found again."""

from functools import cache
from itertools import islice

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from mechanism.description import read_neck
from mechanism.printed_markers import Markers
from tests.paths import SAMPLES
from tests.vision.scene import corners
from vision.light_patch import LightPatch
from vision.markers.tracking import DOUBLED, NOT_FOUND, SEARCHED, TRACKED, MarkerTracker, TrackingOptions
from vision.markers.video_tracking import track_video
from vision.video import Frame, describe_video, read_frames

VIDEO = SAMPLES / "recording/video.mp4"
NECK = read_neck(SAMPLES / "recording/neck.yaml")


def markers() -> Markers:
    assert NECK.markers is not None
    return NECK.markers


@cache
def film() -> tuple[Frame, ...]:
    """The second to fifth second of the sample, the arm in full motion."""
    return tuple(islice(read_frames(VIDEO), 30, 150))


@cache
def truth() -> np.ndarray:
    return corners(NECK, np.load(SAMPLES / "truth.npz")["recording_frame_alpha"])[30:150]


def track(shown: list[Frame]) -> tuple[np.ndarray, np.ndarray]:
    tracker = MarkerTracker(markers())
    seen = [tracker.track(frame) for frame in shown]
    return np.stack([s.corners for s in seen]), np.stack([s.status for s in seen])


def painted(frame: Frame, where: np.ndarray, colour: int, grow: float = 10.0) -> Frame:
    """The frame with the box around some corners painted over."""
    grey = frame.grey.copy()
    (x0, y0), (x1, y1) = (where.min(axis=0) - grow).astype(int), (where.max(axis=0) + grow).astype(int)
    grey[y0:y1, x0:x1] = colour
    return Frame(frame.index, frame.time, grey)


def test_after_two_frames_nothing_is_searched() -> None:
    found, how = track(list(film()))
    assert np.all(how[0] == SEARCHED)
    assert np.all(how[2:] == TRACKED)
    assert np.sqrt(np.mean((found - truth()) ** 2)) < 0.06


def test_a_marker_hidden_for_a_second_is_lost_meanwhile_and_found_again_at_once() -> None:
    shown = [painted(f, truth()[k, 2], 90) if 40 <= k < 70 else f for k, f in enumerate(film())]
    found, how = track(shown)
    assert np.isnan(found[40:70, 2]).all()
    assert np.isfinite(np.delete(found, 2, axis=1)).all()
    back = int(np.argmax(np.isfinite(found[70:, 2, 0, 0])))
    assert back < 5
    assert np.sqrt(np.mean((found[70 + back :, 2] - truth()[70 + back :, 2]) ** 2)) < 0.06
    assert set(how[40:70, 2]) <= {NOT_FOUND, 3}


def test_a_jump_of_the_camera_is_survived() -> None:
    """From frame 60 on the picture is shifted by 40 px, far beyond what prediction reaches."""
    shown = [
        Frame(f.index, f.time, np.roll(f.grey, (7, 40), axis=(0, 1))) if k >= 60 else f for k, f in enumerate(film())
    ]
    found, _ = track(shown)
    assert np.isfinite(found).all()
    assert np.sqrt(np.mean((found[60:] - truth()[60:] - [40, 7]) ** 2)) < 0.06


def test_another_marker_in_its_place_is_not_taken_for_it() -> None:
    """Two markers change places between frames: each is reported where it went, or not at all."""
    shown = list(film())
    for k in range(60, 120):
        grey = shown[k].grey.copy()
        a, b = (np.rint(truth()[k, i].mean(axis=0)).astype(int) for i in (0, 1))
        cut = [grey[p[1] - 42 : p[1] + 42, p[0] - 42 : p[0] + 42].copy() for p in (a, b)]
        for p, patch in ((b, cut[0]), (a, cut[1])):
            grey[p[1] - 42 : p[1] + 42, p[0] - 42 : p[0] + 42] = patch
        shown[k] = Frame(shown[k].index, shown[k].time, grey)
    found, _ = track(shown)
    for k in range(60, 120):
        for i, other in ((0, 1), (1, 0)):
            middle = found[k, i].mean(axis=0)
            if np.isfinite(middle).all():
                assert np.linalg.norm(middle - truth()[k, other].mean(axis=0)) < 5


def test_a_doubled_marker_is_left_out_and_said_so() -> None:
    shown = []
    for k, frame in enumerate(film()[:20]):
        grey = frame.grey.copy()
        x, y = np.rint(truth()[k, 3].mean(axis=0)).astype(int)
        grey[100:190, 1000:1090] = grey[y - 45 : y + 45, x - 45 : x + 45]
        shown.append(Frame(frame.index, frame.time, grey))
    found, how = track(shown)
    assert how[0, 3] == DOUBLED
    assert np.isnan(found[0, 3]).all()
    assert np.isfinite(found[:, :3]).all()


@pytest.mark.parametrize("workers", [2, 3])
def test_the_number_of_processes_changes_nothing(workers: int) -> None:
    video = describe_video(VIDEO)
    assert len(video.segments) == 3
    light = LightPatch(600, 300, 40, 30)
    one, more = track_video(video, markers(), light=light), track_video(video, markers(), workers=workers, light=light)
    np.testing.assert_array_equal(one.time, more.time)
    np.testing.assert_array_equal(one.corners, more.corners)
    np.testing.assert_array_equal(one.status, more.status)
    assert one.light is not None
    assert more.light is not None
    np.testing.assert_array_equal(one.light, more.light)
    eighth = next(frame for frame in read_frames(VIDEO) if frame.index == 7)
    assert one.light[7] == eighth.grey[300:330, 600:640].mean()


@pytest.mark.parametrize("blur_px", [0.0, 2.0, 2.5])
def test_a_lens_out_of_focus_puts_no_corner_off(blur_px: float) -> None:
    """What frames do not average out stays below 0.03 px; with a blur pulled to that of a sharp lens it is 0.05 and 0.08."""
    shown = [Frame(f.index, f.time, np.asarray(gaussian_filter(f.grey, blur_px), dtype=np.uint8)) for f in film()[:40]]
    tracker = MarkerTracker(markers(), TrackingOptions(template=True))
    found = np.stack([tracker.track(frame).corners for frame in shown])[1:]
    assert np.isfinite(found).all()
    assert np.sqrt(np.mean(np.mean(found - truth()[1:40], axis=0) ** 2)) < 0.03
