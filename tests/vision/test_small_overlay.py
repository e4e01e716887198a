"""The small video that a page holds: its frames and their times, the region that it shows, and how large it grows at the most."""

from collections.abc import Iterable, Iterator
from io import BytesIO

import av
import numpy as np
import pytest

from calibration.camera import Camera, camera_from
from identification.dataset.series import Series
from mechanism.description import read_neck
from synchronisation.angles import Angles
from tests.paths import NECK_FILE
from tests.vision.scene import corners
from vision.extract import Extraction
from vision.linkage.linkage_fit import LinkageFit
from vision.overlay_video import MAX_BYTES, MAX_FRAMES, MAX_FRAMES_PER_S, MAX_SIDE_PX, SmallOverlay, small_overlay
from vision.video import Frame

NECK = read_neck(NECK_FILE)
WIDTH, HEIGHT = 640, 512


def camera(width: int = WIDTH, height: int = HEIGHT) -> Camera:
    return camera_from(np.array([900.0, 900.0, width / 2, height / 2, 0, 0, 0, 0, 0]), (width, height))


def extraction(times: np.ndarray, seen: np.ndarray) -> Extraction:
    """With markers at corners (F, 4, 4, 2), px, and no linkage."""
    count = len(times)
    unknown = np.full((count, 3), np.nan)
    zero = np.zeros(6)
    fit = LinkageFit(unknown, np.zeros((count, 3, 3)), zero[:3], zero[3:], zero, 0.1, np.zeros(count))
    return Extraction(Angles(times, unknown, unknown), fit, seen, Series(times, {}))


def overlay(pictures: Iterable[np.ndarray], times: np.ndarray, seen: np.ndarray | None = None) -> SmallOverlay:
    unseen = np.zeros((len(times), 4, 4, 2)) if seen is None else seen
    frames = (Frame(k, float(t), p) for k, (t, p) in enumerate(zip(times, pictures, strict=True)))
    return small_overlay(frames, NECK, camera(), extraction(times, unseen))


def decoded(film: SmallOverlay) -> Iterator[tuple[float, np.ndarray]]:
    with av.open(BytesIO(film.mp4), "r") as container:
        for picture in container.decode(video=0):
            yield float(picture.time or 0.0), picture.to_ndarray(format="gray")


def brightness(count: int) -> np.ndarray:
    return (16 + np.arange(count) * 200 // count).astype(np.uint8)


def test_every_frame_is_that_of_its_time_on_an_uneven_clock() -> None:
    rng = np.random.default_rng(0)
    times = 3.7 + np.cumsum(rng.uniform(0.01, 0.12, 80))
    levels = brightness(len(times))
    film = overlay((np.full((HEIGHT, WIDTH), level) for level in levels), times)
    shown = list(decoded(film))
    assert len(shown) == len(film.frames)
    assert film.frames[0] == 0
    assert np.diff(times[film.frames]).min() > 0
    np.testing.assert_allclose([t for t, _ in shown], times[film.frames] - times[0], atol=1e-4)
    np.testing.assert_allclose([np.median(p[40:]) for _, p in shown], levels[film.frames], atol=3)


def test_a_slow_camera_loses_no_frame_and_a_fast_one_most_of_its_own() -> None:
    for rate, kept in ((10.0, 40), (120.0, 4 * MAX_FRAMES_PER_S)):
        times = np.arange(int(4 * rate)) / rate
        film = overlay((np.zeros((HEIGHT, WIDTH), np.uint8) for _ in times), times)
        assert len(film.frames) == pytest.approx(kept, abs=1)


def test_it_shows_where_the_markers_were() -> None:
    """Dark outside of the region in which they move, light within: nothing dark is seen but the margin's edge."""
    times = np.arange(3) / 30
    seen = np.full((3, 4, 4, 2), np.nan)
    seen[0, 0], seen[2, 1] = (200.0, 100.0), (400.0, 300.0)
    picture = np.zeros((HEIGHT, WIDTH), np.uint8)
    picture[100 - 24 : 300 + 24, 200 - 24 : 400 + 24] = 250  # the margin is .12 of the longer side
    film = overlay([picture] * 3, times, seen)
    assert (film.width, film.height) == (248, 248)
    ((_, first), *_) = decoded(film)
    assert np.mean(first > 200) > 0.98


def test_markers_and_linkage_are_drawn_where_they_are() -> None:
    times = np.arange(2) / 30
    seen = np.repeat(corners(NECK, np.zeros((1, 3))), 2, axis=0)
    seen -= seen.reshape(-1, 2).min(axis=0) - 20
    film = overlay([np.zeros((HEIGHT, WIDTH), np.uint8)] * 2, times, seen)
    with av.open(BytesIO(film.mp4), "r") as container:
        picture = next(container.decode(video=0)).to_ndarray(format="bgr24").astype(int)
    green = picture[..., 1] - picture[..., [0, 2]].max(axis=-1)
    assert green.max() > 60
    assert np.mean(green > 40) < 0.2


@pytest.mark.parametrize("hours", [0.01, 0.1, 2.0])
def test_no_recording_makes_it_large(hours: float) -> None:
    """Noise in every pixel, which no encoder can foresee, for seconds and for hours: it is bounded."""
    times = np.linspace(0, 3600 * hours, 4 * MAX_FRAMES)
    rng = np.random.default_rng(1)
    noise = [rng.integers(0, 255, (HEIGHT, WIDTH), dtype=np.uint8) for _ in range(7)]
    film = overlay((noise[k % 7] for k in range(len(times))), times)
    assert len(film.frames) <= MAX_FRAMES + 1
    assert max(film.width, film.height) <= MAX_SIDE_PX
    assert len(film.mp4) <= MAX_BYTES


def test_the_same_frames_make_the_same_bytes() -> None:
    times = np.arange(20) / 30
    films = [overlay((np.full((HEIGHT, WIDTH), level) for level in brightness(20)), times).mp4 for _ in range(2)]
    assert films[0] == films[1]
