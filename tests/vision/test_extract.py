"""Angles of videos with frames that repeat the picture before them, and of one that is none."""

from dataclasses import replace
from fractions import Fraction
from itertools import islice
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from calibration.camera import Camera
from mechanism.description import markers_of, read_neck
from samples.generator.camera import SAMPLE_CAMERA
from tests.paths import ROOT
from tests.vision.linkage.test_row_time import swinging
from tests.vision.scene import NOISE_PX, corners, rolled
from tests.vision.test_video import film
from vision.extract import Extraction, ExtractionOptions, extract
from vision.markers.video_tracking import MarkerTracks
from vision.shutter import Shutter
from vision.video import Frame, describe_video, read_frames
from xneck_foundation.errors import Refused

R = ROOT / "samples" / "recording"
FIRST, COUNT = 100, 50
"""frames of the sample in which the arm is at speed"""
REPEATED = [20, 33]
CAMERA = Camera(SAMPLE_CAMERA.width, SAMPLE_CAMERA.height, SAMPLE_CAMERA.matrix, np.array([*SAMPLE_CAMERA.distortion]))


def recoded(path: Path, frames: list[Frame], source: list[int]) -> Path:
    """The pictures `source` of the frames at the stamps of all, through a lossy codec."""
    with av.open(str(path), "w") as out:
        stream = out.add_stream("libx264", rate=30, options={"crf": "23", "preset": "veryfast"})
        stream.width, stream.height, stream.pix_fmt = frames[0].grey.shape[1], frames[0].grey.shape[0], "yuv420p"
        stream.codec_context.time_base = Fraction(1, 90_000)
        for frame, shown in zip(frames, source, strict=True):
            planes = np.full((stream.height * 3 // 2, stream.width), 128, dtype=np.uint8)
            planes[: stream.height] = frames[shown].grey
            picture = av.VideoFrame.from_ndarray(planes, format="yuv420p")
            picture.pts, picture.time_base = round((frame.time - frames[0].time) * 90_000), Fraction(1, 90_000)
            out.mux(stream.encode(picture))
        out.mux(stream.encode(None))
    return path


@pytest.fixture(scope="module")
def extractions(tmp_path_factory: pytest.TempPathFactory) -> tuple[Extraction, Extraction]:
    """Of the same frames as they are, and where two of them repeat the picture before."""
    folder = tmp_path_factory.mktemp("extract")
    frames = [replace(f, grey=f.grey.copy()) for f in islice(read_frames(R / "video.mp4"), FIRST, FIRST + COUNT)]
    source = [k - (k in REPEATED) for k in range(COUNT)]
    neck = read_neck(R / "neck.yaml")
    options = ExtractionOptions(shutter=Shutter(row_s=1e-6), template=False)
    whole, repeated = (
        extract(describe_video(recoded(folder / name, frames, shown)), CAMERA, neck, options)
        for name, shown in (("whole.mp4", list(range(COUNT))), ("repeated.mp4", source))
    )
    return whole, repeated


def test_repeated_frames_have_no_angles_and_are_named(extractions: tuple[Extraction, Extraction]) -> None:
    whole, repeated = extractions
    assert whole.as_json()["repeated_frames"] == []
    assert whole.as_json()["warnings"] == []
    record = repeated.as_json()
    assert [entry["frame"] for entry in record["repeated_frames"]] == REPEATED
    assert [entry["time_s"] for entry in record["repeated_frames"]] == repeated.angles.time[REPEATED].tolist()
    (warning,) = record["warnings"]
    assert warning.startswith(
        f"{len(REPEATED)} of {COUNT} frames show the picture before again while the arm moves (at "
    )
    assert [gap["first_frame"] for gap in record["gaps"]] == REPEATED
    assert all("in the picture before, shown again" in gap["cause"] for gap in record["gaps"])


def test_the_other_frames_keep_their_angles(extractions: tuple[Extraction, Extraction]) -> None:
    """Within the codec's errors; a copy's angles would be off by as much as the arm moved since."""
    whole, repeated = (each.angles.alpha for each in extractions)
    assert np.flatnonzero(np.isnan(repeated).any(axis=1)).tolist() == REPEATED
    others = ~np.isnan(repeated).any(axis=1)
    moved = np.abs(np.diff(whole, axis=0))[np.array(REPEATED) - 1].max()
    assert moved > np.radians(0.5)
    assert np.abs(repeated - whole)[others].max() < moved / 5


def test_a_video_of_one_frame_is_refused(tmp_path: Path) -> None:
    camera = replace(CAMERA, width=96, height=64)
    with pytest.raises(Refused, match="has one frame only, which shows no motion"):
        extract(describe_video(film(tmp_path / "a.mp4", [0])), camera, read_neck(R / "neck.yaml"))


def tracks_of_corners(time: np.ndarray, seen: np.ndarray) -> MarkerTracks:
    """Tracks as if these corners had been measured, (F, markers, 4, 2), px."""
    nothing = np.zeros(seen.shape[:2], dtype=np.float32)
    return MarkerTracks(
        time=time,
        corners=seen,
        covariance=None,
        status=nothing.astype(np.int8),
        hidden=nothing,
        clipped=nothing,
        fell_back=nothing.astype(bool),
        row_shift=nothing,
        prints=np.empty((0, 4)),
        foreign_ids=(),
    )


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"dictionary": "apriltag_36h12"}, r"^neck\.yaml: markers\.dictionary: unknown dictionary .*did you mean"),
        ({"dictionary": "aruco_4x4_50", "first_id": 50}, r"^neck\.yaml: markers\.on_bars\[0\]\.id is 50, but"),
        ({"first_bar": 1}, r"^neck\.yaml: no marker sits on the base bar"),
    ],
)
def test_markers_that_cannot_be_are_refused_before_the_video_is_read(
    changes: dict[str, Any], says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    neck = read_neck(R / "neck.yaml")
    assert neck.markers is not None
    first = {"id": changes.pop("first_id", 0), "bar": changes.pop("first_bar", 0), "at": (0.01, 0.0)}
    on_bars = (neck.markers.on_bars[0].model_copy(update=first), *neck.markers.on_bars[1:])
    changed = neck.model_copy(update={"markers": neck.markers.model_copy(update={"on_bars": on_bars, **changes})})
    monkeypatch.setattr("vision.extract.track_video", lambda *args: pytest.fail("the video was read"))
    with pytest.raises(Refused, match=says):
        extract(describe_video(R / "video.mp4"), CAMERA, changed, ExtractionOptions())


def test_frames_of_another_moment_have_no_angles_and_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    neck, time, late = read_neck(R / "neck.yaml"), np.arange(80) / 30, [25, 41]
    taken = time.copy()
    taken[late] -= 0.02
    tracks = tracks_of_corners(time, corners(neck, swinging(5)(taken), seed=2))
    monkeypatch.setattr("vision.extract.track_video", lambda *args: tracks)
    options = ExtractionOptions(shutter=Shutter(row_s=1e-6), template=False)
    found = extract(describe_video(R / "video.mp4"), CAMERA, neck, options)
    record = found.as_json()
    assert [entry["frame"] for entry in record["late_frames"]] == late
    assert [entry["late_s"] for entry in record["late_frames"]] == pytest.approx([0.02, 0.02], abs=0.005)
    assert np.flatnonzero(np.isnan(found.angles.alpha).any(axis=1)).tolist() == late
    assert all("of another moment than the frame's stamp" in gap["cause"] for gap in record["gaps"])
    (warning,) = record["warnings"]
    assert warning.startswith("2 of 80 frames show another moment than their stamps, by up to 2")


def test_a_rolling_shutter_that_nobody_spoke_of_is_corrected_and_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """Corners as a phone's shutter sees them stand in the place of the sample's."""
    neck, time, row_s = read_neck(R / "neck.yaml"), np.arange(300) / 30, 2e-5
    markers = markers_of(neck, "neck.yaml").on_bars
    noise = np.random.default_rng(1).normal(0, NOISE_PX, (300, len(markers), 4, 2))
    seen = rolled(neck, time, swinging(5), row_s) + noise
    tracks = tracks_of_corners(time, seen)
    monkeypatch.setattr("vision.extract.track_video", lambda *args: tracks)
    video = describe_video(R / "video.mp4")

    def extracted(shutter: Shutter) -> Extraction:
        return extract(video, CAMERA, neck, ExtractionOptions(shutter=shutter, template=False))

    found = extracted(Shutter())
    record = found.as_json()
    error = np.degrees(found.angles.alpha - swinging(5)(time))[1:-1]
    assert np.sqrt(np.mean(error**2)) < 0.05
    assert record["row_time"]["used_s"] == pytest.approx(row_s, abs=4 * record["row_time"]["sigma_s"])
    assert record["row_time"]["sigma_s"] < 0.05 * row_s
    (warning,) = record["warnings"]
    assert warning.startswith("a rolling shutter: each row is exposed")
    told = extracted(Shutter(row_s=row_s)).as_json()
    assert told["warnings"] == []
    assert told["row_time"]["used_s"] == row_s
    # what is said is believed, and contradicted
    other = extracted(Shutter(row_s=3e-5)).as_json()
    assert other["row_time"]["used_s"] == 3e-5
    assert other["row_time"]["found_s"] == pytest.approx(row_s, abs=4 * other["row_time"]["sigma_s"])
    (warning,) = other["warnings"]
    assert warning.startswith("a row time of 30.00 us was said, but the motion shows")
