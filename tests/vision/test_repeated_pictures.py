"""Frames that show the picture before them again are told from an arm that stands still."""

import numpy as np
import pytest
from numpy.typing import NDArray

from vision.repeated_pictures import repeated_pictures

Array = NDArray[np.float64]

RATE_HZ = 30.0
TIME = np.arange(150) / RATE_HZ
SQUARE = np.array([[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]])


def corners(time: Array, noise: float = 0.0) -> Array:
    """Three markers at times (F,), s, px: one on the base, two that swing at different rates, 40 px to each side."""
    x = np.stack([0 * time, 40 * np.sin(2.1 * time), 40 * np.sin(3.4 * time)], axis=1)
    y = np.stack([0 * time, 12 * np.cos(1.7 * time), 9 * np.sin(4.0 * time)], axis=1)
    placed = np.stack([x, y], axis=-1)[:, :, None] + SQUARE
    return placed + np.random.default_rng(0).normal(0, noise, placed.shape) if noise else placed


def shown(source: NDArray[np.int_], noise: float = 0.0) -> Array:
    """Corners where frame k shows what frame source[k] should; a codec changes the copies a little."""
    jitter = np.random.default_rng(1).normal(0, 0.005, (len(source), 3, 4, 2))
    return corners(TIME, noise)[source] + jitter


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_single_repeats_in_motion_are_found_and_nothing_else(noise: float) -> None:
    source, bad = np.arange(len(TIME)), [10, 33, 34 + 20, 100, 120]
    source[bad] -= 1
    found = repeated_pictures(TIME, shown(source, noise))
    assert np.flatnonzero(found).tolist() == bad


def test_a_fast_marker_that_a_codec_changes_a_little_is_still() -> None:
    """By 0.13 px of the 4.5 that it moves from frame to frame: more than an arm at rest ever does."""
    source, bad = np.arange(len(TIME)), [27, 55, 110]
    source[bad] -= 1
    seen = shown(source)
    speed = np.linalg.norm(np.diff(corners(TIME)[:, 2, 0], axis=0), axis=1)
    assert speed[np.array(bad) - 2].min() > 3.5
    seen[bad, 2] += 0.13 / np.sqrt(2)
    assert np.flatnonzero(repeated_pictures(TIME, seen)).tolist() == bad


def test_a_frozen_picture_is_found_whole() -> None:
    source = np.arange(len(TIME))
    source[60:65] = 59
    assert np.flatnonzero(repeated_pictures(TIME, shown(source))).tolist() == [60, 61, 62, 63, 64]


@pytest.mark.parametrize(("kept", "every"), [(2, 2), (3, 3), (5, 6)])
def test_a_slower_camera_in_a_faster_file(kept: int, every: int) -> None:
    """15 and 10 pictures a second stored as 30, and 25 stored as 30: most copies in motion are found, and no true picture is."""
    frames = np.arange(len(TIME))
    source = frames // kept * kept if kept == every else frames - (frames % every == every - 1)
    copies = np.r_[False, source[1:] == source[:-1]]
    at = TIME[source] if kept == every else TIME
    found = repeated_pictures(TIME, corners(at)[source])
    assert not (found & ~copies).any()
    assert (found & copies).sum() > 0.7 * copies.sum()


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_an_arm_that_moves_or_stands_repeats_nothing(noise: float) -> None:
    assert not repeated_pictures(TIME, corners(TIME, noise)).any()
    assert not repeated_pictures(TIME, corners(np.full_like(TIME, 0.7), noise)).any()


@pytest.mark.parametrize("deceleration", [1500.0, 4000.0])
@pytest.mark.parametrize("rest", [0.0, 0.1, 1.0])
def test_an_arm_that_stops_and_goes_on_repeats_nothing(deceleration: float, rest: float) -> None:
    """At 150 px/s it is braked by friction, rests, and is driven on the same way: pictures without noise are the same there."""
    for phase in np.linspace(0, 1 / RATE_HZ, 7):
        since = TIME - 2.0 - phase
        stopping = 150.0 / deceleration
        before = 150 * np.minimum(since, 0) + np.where(
            since > 0, 150 * np.minimum(since, stopping) - deceleration * np.minimum(since, stopping) ** 2 / 2, 0
        )
        again = np.maximum(since - stopping - rest, 0)
        after = np.where(again < stopping, deceleration * again**2 / 2, 150 * again - 75 * stopping)
        places = np.zeros((len(TIME), 2, 4, 2))
        places[:, 1, :, 0] = (before + after)[:, None]
        assert not repeated_pictures(TIME, places + SQUARE).any()


def test_a_motion_that_turns_over_between_two_frames_repeats_nothing() -> None:
    """The markers are at the same place in both, without noise to the last bit."""
    place = np.zeros((len(TIME), 1, 4, 2))
    place[:, 0, :, 0] = 80 * np.cos(4 * (TIME - TIME[70] - 0.5 / RATE_HZ))[:, None]
    assert abs(place[70] - place[71]).max() < 1e-9
    assert not repeated_pictures(TIME, place + SQUARE).any()


def turning(since: Array) -> Array:
    """Two markers at times (F,), s, from where their motion turns over: they move 3 and 5 px from frame to frame soon after."""
    places = np.zeros((len(since), 2, 4, 2))
    places[:, 0, :, 0] = 60 * np.cos(2.2 * since)[:, None]
    places[:, 1, :, 0] = 80 * np.cos(2.6 * since)[:, None]
    places[:, 1, :, 1] = 30 * np.cos(2.4 * since + 0.1)[:, None]
    return places + SQUARE


@pytest.mark.parametrize("repeats", [2, 3])
def test_pictures_that_are_repeated_while_the_motion_turns_over_are_found(repeats: int) -> None:
    """The arm comes one way and goes another, and is off its smooth path by a pixel at most."""
    source = np.arange(len(TIME))
    source[70 : 70 + repeats] = 69
    seen = turning(TIME - TIME[71])[source]
    seen += np.random.default_rng(3).normal(0, 0.005, seen.shape)
    assert np.flatnonzero(repeated_pictures(TIME, seen)).tolist() == [*range(70, 70 + repeats)]


def test_a_second_repeat_soon_after_the_first_is_found() -> None:
    source = np.arange(len(TIME))
    source[[70, 71, 73]] = [69, 69, 72]
    seen = turning(TIME - TIME[74])[source]
    assert np.flatnonzero(repeated_pictures(TIME, seen)).tolist() == [70, 71, 73]


@pytest.mark.parametrize("deceleration", [1500.0, 4000.0, 40000.0])
@pytest.mark.parametrize("rest", [0.03, 0.05, 0.07, 0.1, 0.2])
def test_an_arm_that_is_braked_stands_and_is_driven_back_repeats_nothing(deceleration: float, rest: float) -> None:
    """From 150 px/s, in 14 phases against the frames, and slow ones as well as fast."""
    for phase in np.linspace(0, 1 / RATE_HZ, 14):
        since = TIME - 2.0 - phase
        stopping = 150.0 / deceleration
        reached = np.clip(since, 0, stopping)
        before = 150 * np.minimum(since, 0) + 150 * reached - deceleration * reached**2 / 2
        again = np.maximum(since - stopping - rest, 0)
        after = np.where(again < stopping, deceleration * again**2 / 2, 150 * again - 75 * stopping)
        places = np.zeros((len(TIME), 2, 4, 2))
        places[:, 1, :, 0] = (before - after)[:, None]
        places[:, 0, :, 0] = 0.4 * (before - after)[:, None]
        assert not repeated_pictures(TIME, places + SQUARE).any(), phase


def test_markers_that_are_not_seen_tell_nothing() -> None:
    source = np.arange(len(TIME))
    source[[40, 80]] -= 1
    hidden = shown(source)
    hidden[78:83, 1:] = np.nan
    found = repeated_pictures(TIME, hidden)
    assert np.flatnonzero(found).tolist() == [40]
    assert not repeated_pictures(TIME, np.full_like(hidden, np.nan)).any()
    assert not repeated_pictures(TIME[:1], hidden[:1]).any()
