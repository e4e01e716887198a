"""Videos that are unusual: cut, joined, changed while they are read, of many formats. Right, or refused for the true reason."""

import os
import shutil
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from av.stream import Disposition

from tests.vision.test_video import STAMPS, film
from tests.vision.test_video_file import levels
from vision.video import describe_video, read_frames, read_segments
from xneck_foundation.errors import Refused

FIRST_GREY = 50
"""luma of the first frame of `film`"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a film in three containers."""
    folder = tmp_path_factory.mktemp("films")
    for name, form in (("a.mp4", "mp4"), ("a.mkv", "matroska"), ("a.ts", "mpegts")):
        film(folder / name, STAMPS, form)
    return folder


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("a.mp4", "is several videos joined end to end"),
        ("a.mkv", "is several videos joined end to end"),
        ("a.ts", r"its time stamps go back from 1\.\d+ to 0\.\d+ s, as where parts are joined"),
    ],
)
def test_parts_that_were_joined_are_refused(name: str, reason: str, whole: Path, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(2 * (whole / name).read_bytes())
    with pytest.raises(Refused, match=reason):
        list(read_frames(tmp_path / name))


def test_parts_joined_with_a_later_clock_are_read_and_the_gap_is_named(whole: Path, tmp_path: Path) -> None:
    later = film(tmp_path / "later.ts", [90_000 * 100 + stamp for stamp in STAMPS], "mpegts")
    path = tmp_path / "a.ts"
    path.write_bytes((whole / "a.ts").read_bytes() + later.read_bytes())
    video = describe_video(path)
    assert len(list(read_segments(video))) == 2 * len(STAMPS)
    assert [warning[:17] for warning in video.warnings] == ["no frame for 98.7"]


def test_a_size_that_changes_is_refused(whole: Path, tmp_path: Path) -> None:
    with av.open(str(tmp_path / "small.ts"), "w", format="mpegts") as out:
        stream = out.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.codec_context.time_base = Fraction(1, 90_000)
        for k in range(5):
            frame = av.VideoFrame.from_ndarray(np.full((48, 64), 90, np.uint8), format="gray").reformat(
                format="yuv420p"
            )
            frame.pts, frame.time_base = 180_000 + 3000 * k, Fraction(1, 90_000)
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    path = tmp_path / "a.ts"
    path.write_bytes((whole / "a.ts").read_bytes() + (tmp_path / "small.ts").read_bytes())
    with pytest.raises(Refused, match=rf"frame {len(STAMPS)} is 64x48, those before it are 96x64"):
        list(read_frames(path))


def remuxed(source: Path, path: Path, first: int, earlier_s: float) -> None:
    """The packets from `first` on, shown so much earlier, as tools cut without loss."""
    with av.open(str(source)) as before, av.open(str(path), "w") as after:
        stream = after.add_stream_from_template(before.streams.video[0])
        for k, packet in enumerate(before.demux(video=0)):
            if packet.dts is None or packet.pts is None or k < first:
                continue
            ticks = round(earlier_s / float(packet.time_base))
            packet.pts, packet.dts, packet.stream = packet.pts - ticks, packet.dts - ticks, stream
            after.mux(packet)


@pytest.mark.parametrize("b_frames", ["0", "2"])
def test_a_cut_without_loss_shows_the_frames_that_players_show(b_frames: str, tmp_path: Path) -> None:
    """It begins at a key frame before the cut, with stamps below zero that an edit list hides."""
    source = film(
        tmp_path / "a.mp4", [3000 * k for k in range(40)], options={"g": "10", "bf": b_frames, "sc_threshold": "0"}
    )
    remuxed(source, tmp_path / "cut.mp4", 10, 10 / 30 + 0.2)
    shown = list(read_frames(tmp_path / "cut.mp4"))
    every = list(read_frames(source))
    assert [frame.index for frame in shown] == list(range(24))
    np.testing.assert_allclose([f.time for f in shown], [f.time - 16 / 30 for f in every[16:]], atol=1e-3)
    for a, b in zip(shown, every[16:], strict=True):
        np.testing.assert_array_equal(a.grey, b.grey)


@pytest.mark.parametrize("name", ["cut.mp4", "cut.mkv"])
def test_frames_before_the_first_key_frame_are_left_out_and_named(name: str, tmp_path: Path) -> None:
    source = film(tmp_path / "a.mp4", [3000 * k for k in range(40)], options={"g": "10", "sc_threshold": "0"})
    remuxed(source, tmp_path / name, 3, 0.0)
    video = describe_video(tmp_path / name)
    shown = list(read_segments(video))
    assert video.warnings == ("the first 7 frames need a key frame that is not in the file: they are left out",)
    assert [frame.index for frame in shown] == list(range(video.frames)) == list(range(30))
    np.testing.assert_array_equal(shown[0].grey, list(read_frames(source))[10].grey)


@pytest.mark.parametrize(
    ("form", "suffix"), [("mpegts", ".ts"), ("matroska", ".mkv"), ("mov", ".mov"), ("avi", ".avi")]
)
def test_long_videos_are_whole_in_every_container(form: str, suffix: str, tmp_path: Path) -> None:
    """Segments begin where the container finds its key frames again; MPEG-TS finds others, and is read in one."""
    options = {"g": "50", "bf": "0" if form == "avi" else "3"}
    video = describe_video(film(tmp_path / f"a{suffix}", [3000 * k for k in range(400)], form, options=options))
    assert len(video.segments) == (1 if form == "mpegts" else 2)
    alone = [frame.index for frame in read_segments(video)]
    assert alone == list(range(400))


def test_avi_cannot_hold_the_stamps_of_b_frames(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="AVI cannot hold the stamps of B-frames; record into mp4 or mkv"):
        list(read_frames(film(tmp_path / "a.avi", STAMPS, "avi", options={"bf": "3"})))


def test_sound_alone_and_a_cover_are_no_video(tmp_path: Path) -> None:
    for cover in (False, True):
        with av.open(str(tmp_path / "a.mp4"), "w") as out:
            sound = out.add_stream("aac", rate=8000)
            if cover:
                stream = out.add_stream("mjpeg", rate=1)
                stream.width, stream.height, stream.pix_fmt = 96, 64, "yuvj420p"
                stream.disposition = Disposition.attached_pic.value  # type: ignore[assignment]  # PyAV 17 takes numbers only
                picture = av.VideoFrame.from_ndarray(np.full((96, 96), 99, np.uint8), format="yuvj420p")
                picture.pts = 0
                out.mux(stream.encode(picture))
                out.mux(stream.encode(None))
            for k in range(4):
                samples = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
                samples.sample_rate, samples.pts = 8000, 1024 * k
                out.mux(sound.encode(samples))
            out.mux(sound.encode(None))
        with pytest.raises(Refused, match="has no video in it" + (", only a cover picture" if cover else ";")):
            describe_video(tmp_path / "a.mp4")


def test_of_two_videos_the_first_is_read_and_that_is_said(tmp_path: Path) -> None:
    with av.open(str(tmp_path / "a.mkv"), "w") as out:
        streams = [out.add_stream("libx264", rate=30) for _ in range(2)]
        for stream in streams:
            stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
        for grey, stream in zip((60, 160), streams, strict=True):
            for k in range(5):
                frame = av.VideoFrame.from_ndarray(np.full((96, 96), grey, np.uint8), format="yuv420p")
                frame.pts, frame.time_base = k, Fraction(1, 30)
                out.mux(stream.encode(frame))
            out.mux(stream.encode(None))
    video = describe_video(tmp_path / "a.mkv")
    assert video.warnings == ("of the 2 videos in the file the first one is read",)
    assert levels(tmp_path / "a.mkv") == [60] * 5


def test_interlaced_video_is_read_with_a_warning(tmp_path: Path) -> None:
    video = describe_video(film(tmp_path / "a.mp4", STAMPS[:5], options={"x264-params": "interlaced=1:tff=1"}))
    assert [warning[:34] for warning in video.warnings] == ["the video is marked as interlaced:"]
    assert describe_video(film(tmp_path / "b.mp4", STAMPS[:5])).warnings == ()


def test_a_mirrored_video_is_refused(whole: Path, tmp_path: Path) -> None:
    data = (whole / "a.mp4").read_bytes()
    upright = b"".join(n.to_bytes(4, "big") for n in (65536, 0, 0, 0, 65536, 0, 0, 0, 0x40000000))
    mirrored = (-65536).to_bytes(4, "big", signed=True) + upright[4:]
    at = data.index(upright, data.index(b"tkhd"))
    (tmp_path / "a.mp4").write_bytes(data[:at] + mirrored + data[at + 36 :])
    with pytest.raises(Refused, match="is tagged as mirrored"):
        describe_video(tmp_path / "a.mp4")


@pytest.mark.parametrize("pixels", ["yuvj420p", "yuv422p", "yuv444p", "yuv420p10le", "yuv444p10le", "gray", "gray10le"])
def test_every_format_with_luma_gives_it_as_it_is(pixels: str, tmp_path: Path) -> None:
    full = pixels in ("yuvj420p", "gray", "gray10le")
    first = levels(film(tmp_path / "a.mkv", STAMPS[:3], "matroska", pixels))[0]
    assert first == pytest.approx(40 if full else FIRST_GREY, abs=1)


@pytest.mark.parametrize("pixels", ["bgr0", "bgra", "gray16le", "gbrp12le"])
def test_odd_sizes_colours_and_alpha_become_grey(pixels: str, tmp_path: Path) -> None:
    with av.open(str(tmp_path / "a.mkv"), "w") as out:
        stream = out.add_stream("ffv1", rate=30)
        stream.width, stream.height, stream.pix_fmt = 97, 65, pixels
        for k in range(3):
            frame = av.VideoFrame.from_ndarray(np.full((65, 97), 40 + 4 * k, np.uint8), format="gray").reformat(
                format=pixels
            )
            frame.pts = k
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    frames = list(read_frames(tmp_path / "a.mkv"))
    assert {frame.grey.shape for frame in frames} == {(65, 97)}
    np.testing.assert_allclose([np.median(frame.grey) for frame in frames], [40, 44, 48], atol=1)


def test_a_title_that_is_no_utf_8_is_no_damage(whole: Path, tmp_path: Path) -> None:
    with av.open(str(whole / "a.mkv")) as source, av.open(str(tmp_path / "a.mkv"), "w") as out:
        out.metadata["title"] = "Versuch"
        stream = out.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                out.mux(packet)
    (tmp_path / "a.mkv").write_bytes((tmp_path / "a.mkv").read_bytes().replace(b"Versuch", b"\xff\xfersuch"))
    assert len(levels(tmp_path / "a.mkv")) == len(STAMPS)


@pytest.mark.parametrize("change", ["written", "replaced", "cut"])
def test_a_file_that_changes_while_it_is_read_is_refused_for_that(change: str, whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    shutil.copy(whole / "a.mp4", path)
    frames = read_segments(describe_video(path))
    next(frames)
    if change == "written":
        with path.open("ab") as stream:
            stream.write(b"more")
    elif change == "replaced":
        shutil.copy(whole / "a.mp4", tmp_path / "other.mp4")
        (tmp_path / "other.mp4").replace(path)
    else:
        os.truncate(path, 3000)
    with pytest.raises(Refused, match="was changed or replaced while it was being read"):
        list(frames)
