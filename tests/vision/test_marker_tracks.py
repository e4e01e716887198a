"""Markers of a video without an arm: corners and turns of those that are there, and of no others."""

import json
from pathlib import Path

import av
import numpy as np
import pytest

from calibration.dictionaries import marker_cells
from tests.command import run
from tests.paths import SAMPLES, SHARED
from tests.vision.markers.test_tracking import NECK, VIDEO
from tests.vision.scene import corners
from vision.marker_tracks import TracksOptions, track_markers
from vision.shutter import Shutter
from vision.video import describe_video, read_frames
from xneck_foundation.errors import Refused

FAMILY = "apriltag_36h11"


@pytest.fixture(scope="module")
def truth() -> np.ndarray:
    return corners(NECK, np.load(SAMPLES / "truth.npz")["recording_frame_alpha"])


def turn(of: np.ndarray) -> np.ndarray:
    """Direction of the side from the top left to the top right corner and its opposite, y up."""
    along = (of[..., 1, :] - of[..., 0, :]) + (of[..., 2, :] - of[..., 3, :])
    return np.unwrap(np.angle(along[..., 0] - 1j * along[..., 1]), axis=0)


@pytest.mark.slow
def test_the_samples_markers_are_where_they_were_rendered(truth: np.ndarray) -> None:
    """Each turn errs as its sigma says over 714 frames, but for what coding repeats from frame to frame (half of an error is that
    of the frame before); the lens bends squares by some hundredths of a pixel, which stay."""
    found = track_markers(describe_video(VIDEO), TracksOptions(FAMILY, Shutter(exposure_s=0.004)))
    assert found.ids == (0, 1, 2, 3)
    assert np.isfinite(found.corners).all()
    assert np.sqrt(np.mean((found.corners - truth) ** 2)) < 0.05
    error = found.turn - turn(truth)
    noise = error - error.mean(axis=0)
    assert 0.8 < np.sqrt(np.mean((noise / found.sigma_turn) ** 2)) < 1.6
    assert np.max(np.abs(error.mean(axis=0))) < np.radians(0.03)


def test_no_marker_of_the_dictionary_is_refused() -> None:
    says = (
        "shows no marker of aruco_5x5_100 in 40 frames spread over it, but markers of apriltag_36h11; give --dictionary"
    )
    with pytest.raises(Refused, match=says):
        track_markers(describe_video(VIDEO), TracksOptions("aruco_5x5_100"))


def film(path: Path, *markers: tuple[int, int, int], mirrored: bool = False) -> Path:
    """Six frames of markers (id, side and left edge, px) that stand side by side."""
    picture = np.full((240, 320), 220, dtype=np.uint8)
    for marker_id, side, x in markers:
        cells = marker_cells(FAMILY, marker_id)
        whole = np.kron(np.where(cells, 25, 220), np.ones((side, side))).astype(np.uint8)
        whole = whole.reshape(side, len(cells), side, len(cells))
        picture[90 : 90 + side, x : x + side] = whole.mean(axis=(1, 3))
    shown = np.ascontiguousarray(picture[:, ::-1]) if mirrored else picture
    with av.open(str(path), "w") as out:
        stream = out.add_stream("libx264", rate=30, options={"crf": "12"})
        stream.width, stream.height, stream.pix_fmt = 320, 240, "yuv420p"
        for _ in range(6):
            out.mux(stream.encode(av.VideoFrame.from_ndarray(shown, format="gray").reformat(format="yuv420p")))
        out.mux(stream.encode(None))
    return path


def test_a_small_marker_beside_large_ones_is_followed(tmp_path: Path) -> None:
    """Of 11 px, which a search of the picture as it is does not find: small ones were searched only where there was none at all."""
    video = film(tmp_path / "a.mkv", (3, 80, 40), (5, 11, 220))
    found = track_markers(describe_video(video), TracksOptions(FAMILY))
    assert found.ids == (3, 5)
    assert np.abs(found.corners[:, 1, 0] - (219.5, 89.5)).max() < 0.3


def test_a_mirrored_picture_is_named(tmp_path: Path) -> None:
    """It was asked whether markers are sharp."""
    video = film(tmp_path / "a.mkv", (3, 80, 40), (5, 60, 220), mirrored=True)
    with pytest.raises(
        Refused, match=f"its picture is mirrored: markers of {FAMILY} are seen only with left and right"
    ):
        track_markers(describe_video(video), TracksOptions(FAMILY))


@pytest.mark.skipif(not SHARED.is_dir(), reason="shared data not beside the checkout")
def test_markers_that_nobody_here_made(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Twelve markers held before an endoscope: by command, with the same corners as the detector has in the first frame."""
    video = SHARED / "markers/scikit_surgery/12markers.avi"
    out, record = tmp_path / "markers.csv", tmp_path / "markers.json"
    ran = run(capfd, "extract", video, "--dictionary", "aruco_6x6_250", "--out", out, "--json", record)
    assert ran.status == 0
    said = json.loads(record.read_text())
    assert {m["id"] for m in said["markers"]} <= set(range(1, 13))
    assert len(said["markers"]) >= 10
    table = np.atleast_1d(np.genfromtxt(out, delimiter=",", names=True))
    assert len(table) == said["frames"] == sum(1 for _ in read_frames(video))


def test_without_an_arm_and_without_a_dictionary_nothing_is_guessed(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    neither = run(capfd, "extract", VIDEO, "--out", tmp_path / "a.csv")
    both = run(capfd, "extract", VIDEO, "--placement", "--dictionary", FAMILY, "--out", tmp_path / "a.csv")
    assert neither.status == both.status == 2
    assert "--neck" in neither.err
    assert "--placement needs an arm" in both.err
    assert not list(tmp_path.iterdir())
