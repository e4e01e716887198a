"""Every frame with its own stamp, and damage named."""

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from vision.video import describe, frames
from xneck.errors import Refused

TICK = Fraction(1, 90_000)


def film(path: Path, stamps: list[int], form: str = "mp4", pixels: str = "yuv420p") -> Path:
    """A film whose frame k is grey level 40 + 4 k, at stamps in ticks of 1/90000 s."""
    options = {"movflags": "faststart", "movie_timescale": "90000"} if form == "mp4" else {}
    with av.open(str(path), "w", format=form, options=options) as container:
        stream = container.add_stream("libx264", rate=30, options={"bf": "0", "crf": "18"})
        stream.width, stream.height, stream.pix_fmt = 96, 64, pixels
        stream.codec_context.time_base = TICK
        rng = np.random.default_rng(0)
        for k, stamp in enumerate(stamps):
            picture = np.full((64, 96), 40 + 4 * k, dtype=np.uint8)
            picture[:8] = rng.integers(0, 255, (8, 96))  # something to code, so that the file has a size
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format=pixels)
            frame.pts, frame.time_base = stamp, TICK
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


STAMPS = [3000 * k + (7 * k) % 50 for k in range(40) if k not in (11, 12, 30)]


@pytest.mark.parametrize(("form", "name", "step"), [("mp4", "a.mp4", 1 / 90_000), ("matroska", "a.mkv", 1e-3)])
def test_stamps_come_back_as_written_to_the_containers_resolution(
    tmp_path: Path, form: str, name: str, step: float
) -> None:
    seen = list(frames(film(tmp_path / name, STAMPS, form)))
    assert [f.index for f in seen] == list(range(len(STAMPS)))
    np.testing.assert_allclose([f.time for f in seen], np.array(STAMPS) / 90_000, atol=step)


def test_an_avi_counts_slots_of_dropped_frames_and_is_whole_all_the_same(tmp_path: Path) -> None:
    path = film(tmp_path / "a.avi", STAMPS, "avi")
    with av.open(str(path)) as container:
        assert container.streams.video[0].frames > len(STAMPS)
    assert len(list(frames(path))) == len(STAMPS)


def test_grey_is_the_luma_in_order(tmp_path: Path) -> None:
    levels = [float(np.median(f.grey[16:])) for f in frames(film(tmp_path / "a.mp4", STAMPS))]
    assert np.all(np.diff(levels) > 0)
    assert {f.grey.shape for f in frames(tmp_path / "a.mp4")} == {(64, 96)}


def test_ten_bits_give_the_same_grey_as_eight(tmp_path: Path) -> None:
    eight = list(frames(film(tmp_path / "8.mp4", STAMPS[:5])))
    ten = list(frames(film(tmp_path / "10.mp4", STAMPS[:5], pixels="yuv420p10le")))
    for a, b in zip(eight, ten, strict=True):
        scale = np.median(b.grey[16:].astype(float)) / np.median(a.grey[16:].astype(float))
        assert 0.7 < scale < 1.4


def test_description_counts_the_frames(tmp_path: Path) -> None:
    video = describe(film(tmp_path / "a.mp4", STAMPS))
    assert (video.width, video.height, video.frames) == (96, 64, len(STAMPS))


def test_a_video_cut_anywhere_is_refused(tmp_path: Path) -> None:
    whole = film(tmp_path / "a.mp4", STAMPS).read_bytes()
    cut = tmp_path / "cut.mp4"
    for share in (0.02, 0.3, 0.6, 0.9, 0.99):
        cut.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(Refused, match=r"truncated|damaged|not a video"):
            list(frames(cut))


def test_what_is_no_video_is_refused_by_name(tmp_path: Path) -> None:
    text = tmp_path / "text.mp4"
    text.write_text("this is not a film\n" * 100)
    empty = tmp_path / "empty.mp4"
    empty.write_bytes(b"")
    for path in (text, empty, tmp_path / "absent.mp4", tmp_path):
        with pytest.raises(Refused, match=path.name):
            list(frames(path))


def test_a_bare_stream_has_no_stamps(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="without time stamps"):
        list(frames(film(tmp_path / "a.h264", STAMPS, "h264")))
