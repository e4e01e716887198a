"""A second print of a marker in view is not taken for the marker, whichever of the two is hidden, and is named."""

import numpy as np
import pytest

from mechanism.description import markers_of
from tests.vision.markers.test_tracking import NECK, VIDEO, film, painted, truth
from vision.arm_reach import arm_reach
from vision.marker_tracks import TracksOptions, track_markers
from vision.markers.tracking import DOUBLED, OTHER_PRINT, MarkerTracker
from vision.markers.video_tracking import MarkerTracks, tracks_of
from vision.second_prints import LeftOut, second_print_warnings, second_prints, without_second_prints
from vision.video import Frame, describe_video

MARKER, HALF_PX = 2, 45
SPARE_PX = np.array([1100, 150])
"""where a spare print of marker 2 lies, outside of the arm's reach"""


def with_spare(k: int, own: bool, spare: bool) -> Frame:
    """Frame k of the film with marker 2 covered or not, and a spare print of it lying there or not."""
    frame = film()[k]
    shown = frame if own else painted(frame, truth()[k, MARKER], 90, grow=20)
    grey = shown.grey.copy()
    if spare:
        cx, cy = SPARE_PX
        x, y = np.rint(truth()[0, MARKER].mean(axis=0)).astype(int)
        print_of_it = film()[0].grey[y - HALF_PX : y + HALF_PX, x - HALF_PX : x + HALF_PX]
        grey[cy - HALF_PX : cy + HALF_PX, cx - HALF_PX : cx + HALF_PX] = print_of_it
    return Frame(frame.index, frame.time, grey)


def followed(own: np.ndarray, spare: np.ndarray) -> MarkerTracks:
    tracker = MarkerTracker(markers_of(NECK, "neck.yaml"))
    return tracks_of(
        [tracker.track(with_spare(k, bool(o), bool(s))) for k, (o, s) in enumerate(zip(own, spare, strict=True))], None
    )


def cleaned(tracks: MarkerTracks, reach: np.ndarray | None) -> tuple[MarkerTracks, list[LeftOut]]:
    left_out = second_prints(tracks.time, tracks.corners, tracks.status, tracks.prints, reach)
    return without_second_prints(tracks, left_out), left_out


def off_px(tracks: MarkerTracks) -> np.ndarray:
    """How far marker 2 is said to be from where it is, px, in frames in which it is said to be anywhere."""
    off = np.linalg.norm(
        tracks.corners[:, MARKER].mean(axis=1) - truth()[: len(tracks.time), MARKER].mean(axis=1), axis=1
    )
    return off[~np.isnan(off)]


@pytest.mark.parametrize("reach", [None, arm_reach(NECK)], ids=["markers alone", "an arm"])
def test_a_spare_print_that_appears_as_the_marker_is_covered_is_not_followed(reach: np.ndarray | None) -> None:
    frames = np.arange(60)
    hidden = (frames >= 20) & (frames < 40)
    before = followed(~hidden, hidden)
    assert np.max(off_px(before)) > 100
    tracks, (left_out,) = cleaned(before, reach)
    assert np.max(off_px(tracks)) < 1
    assert np.isnan(tracks.corners[20:40, MARKER]).all()
    assert np.isfinite(np.delete(tracks.corners, range(20, 41), axis=0)).all()
    assert set(tracks.status[22:40, MARKER]) == {OTHER_PRINT}
    assert left_out.jump_px == pytest.approx(np.linalg.norm(SPARE_PX - truth()[19, MARKER].mean(axis=0)), abs=3)
    (said,) = second_print_warnings(tracks.time, [left_out], [10, 11, 12, 13])
    assert said.startswith("marker 12: another print of it is seen alone, ")


def test_of_two_prints_that_are_there_from_the_start_the_arm_tells_its_own() -> None:
    frames = np.arange(60)
    hidden = (frames >= 10) & (frames < 20)
    both = followed(~hidden, frames < 40)
    assert (both.status[:10, MARKER] == DOUBLED).all()
    by_arm, _ = cleaned(both, arm_reach(NECK))
    assert np.max(off_px(by_arm)) < 1
    assert np.isnan(by_arm.corners[:40, MARKER]).all()
    assert np.isfinite(by_arm.corners[42:, MARKER]).all()


def test_without_an_arm_nothing_tells_which_of_the_two_is_meant() -> None:
    frames = np.arange(40)
    both = followed((frames < 10) | (frames >= 20), frames >= 0)
    tracks, (left_out,) = cleaned(both, None)
    assert np.isnan(tracks.corners[:, MARKER]).all()
    assert np.isnan(left_out.jump_px)
    (said,) = second_print_warnings(tracks.time, [left_out], [0, 1, 2, 3])
    assert "two prints of it are in view, and nothing tells which is meant" in said


def test_what_was_followed_before_the_spare_came_is_followed_after_it_went() -> None:
    frames = np.arange(60)
    tracks, left_out = cleaned(followed(frames >= 0, (frames >= 15) & (frames < 30)), None)
    assert left_out == []
    assert np.max(off_px(tracks)) < 1
    assert np.isfinite(tracks.corners[32:]).all()


def test_markers_alone_say_which_of_them_has_another_print(monkeypatch: pytest.MonkeyPatch) -> None:
    frames = np.arange(60)
    hidden = (frames >= 20) & (frames < 40)
    tracks = followed(~hidden, hidden)
    monkeypatch.setattr("vision.marker_tracks.track_video", lambda *args: tracks)
    monkeypatch.setattr("vision.marker_tracks._ids_in_view", lambda *args: (4, 5, 6, 7))
    found = track_markers(describe_video(VIDEO), TracksOptions("apriltag_36h11", template=False))
    left_out = [marker["other_prints"] for marker in found.as_json()["markers"]]
    assert left_out[:2] + left_out[3:] == [0, 0, 0]
    assert left_out[MARKER] > 15
    (said,) = found.warnings
    assert said.startswith("marker 6: another print of it is seen alone, ")


def swinging(time: np.ndarray, rate_hz: float) -> np.ndarray:
    """Corners of three markers of 30 px, the second and third of which swing by 350 px to each side."""
    square = 15 * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
    x = np.stack([0 * time, 350 * np.sin(2 * np.pi * rate_hz * time), 350 * np.cos(2 * np.pi * rate_hz * time)], axis=1)
    places = np.stack([x, np.broadcast_to([0.0, 300, 600], x.shape)], axis=-1)
    return places[:, :, None] + square


@pytest.mark.parametrize("rate_hz", [0.5, 2.0])
@pytest.mark.parametrize("frames_s", [10.0, 30.0, 120.0])
def test_a_fast_arm_and_a_knocked_camera_are_no_second_prints(rate_hz: float, frames_s: float) -> None:
    """Each sighting a new search, a tenth of them without success, and the picture moved by 400 px from the 100th on."""
    time = np.arange(200) / frames_s
    corners = swinging(time, rate_hz)
    corners[100:] += 400
    corners[np.random.default_rng(3).random(corners.shape[:2]) < 0.1] = np.nan
    searched = np.ones(corners.shape[:2], dtype=np.int8)
    assert second_prints(time, corners, searched, np.empty((0, 4)), None) == []
