"""Every frame with its own stamp, and damage named."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from samples.generator.video import tag_as_turned
from tests.vision.linkage.test_linkage_fit import camera
from vision.extract import refuse_other_size
from vision.video import describe_video, read_frames, read_segment
from xneck_foundation.errors import Refused

TICK = Fraction(1, 90_000)


def film(
    path: Path,
    stamps: list[int],
    form: str = "mp4",
    pixels: str = "yuv420p",
    options: dict[str, str] | None = None,
) -> Path:
    """A film whose frame k is grey level 40 + 4 k (mod 200), at stamps in ticks of 1/90000 s."""
    container_options = {"movflags": "faststart", "movie_timescale": "90000"} if form == "mp4" else {}
    with av.open(str(path), "w", format=form, options=container_options) as container:
        stream = container.add_stream("libx264", rate=30, options={"bf": "0", "crf": "18", **(options or {})})
        stream.width, stream.height, stream.pix_fmt = 96, 64, pixels
        stream.codec_context.time_base = TICK
        rng = np.random.default_rng(0)
        for k, stamp in enumerate(stamps):
            picture = np.full((64, 96), 40 + 4 * k % 200, dtype=np.uint8)
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
    seen = list(read_frames(film(tmp_path / name, STAMPS, form)))
    assert [f.index for f in seen] == list(range(len(STAMPS)))
    np.testing.assert_allclose([f.time for f in seen], np.array(STAMPS) / 90_000, atol=step)


def test_an_avi_counts_slots_of_dropped_frames_and_is_whole_all_the_same(tmp_path: Path) -> None:
    path = film(tmp_path / "a.avi", STAMPS, "avi")
    with av.open(str(path)) as container:
        assert container.streams.video[0].frames > len(STAMPS)
    assert len(list(read_frames(path))) == len(STAMPS)


def test_grey_is_the_luma_in_order(tmp_path: Path) -> None:
    levels = [float(np.median(f.grey[16:])) for f in read_frames(film(tmp_path / "a.mp4", STAMPS))]
    assert np.all(np.diff(levels) > 0)
    assert {f.grey.shape for f in read_frames(tmp_path / "a.mp4")} == {(64, 96)}


def test_ten_bits_give_the_same_grey_as_eight(tmp_path: Path) -> None:
    eight = list(read_frames(film(tmp_path / "8.mp4", STAMPS[:5])))
    ten = list(read_frames(film(tmp_path / "10.mp4", STAMPS[:5], pixels="yuv420p10le")))
    for a, b in zip(eight, ten, strict=True):
        scale = np.median(b.grey[16:].astype(float)) / np.median(a.grey[16:].astype(float))
        assert 0.7 < scale < 1.4


def test_description_counts_the_frames(tmp_path: Path) -> None:
    video = describe_video(film(tmp_path / "a.mp4", STAMPS))
    assert (video.width, video.height, video.frames) == (96, 64, len(STAMPS))


def test_a_video_cut_anywhere_is_refused(tmp_path: Path) -> None:
    whole = film(tmp_path / "a.mp4", STAMPS).read_bytes()
    cut = tmp_path / "cut.mp4"
    for share in (0.02, 0.3, 0.6, 0.9, 0.99):
        cut.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(Refused, match=r"truncated|damaged|not a video|no frame"):
            list(read_frames(cut))


def test_what_is_no_video_is_refused_by_name(tmp_path: Path) -> None:
    text = tmp_path / "text.mp4"
    text.write_text("this is not a film\n" * 100)
    empty = tmp_path / "empty.mp4"
    empty.write_bytes(b"")
    for path in (text, empty, tmp_path / "absent.mp4", tmp_path):
        with pytest.raises(Refused, match=path.name):
            list(read_frames(path))


def test_a_bare_stream_has_no_stamps(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="without time stamps"):
        list(read_frames(film(tmp_path / "a.h264", STAMPS, "h264")))


def test_a_video_turned_by_its_tag_is_shown_upright(tmp_path: Path) -> None:
    """A portrait film of a phone: what was the top row (coded noise) stands at the right after a quarter turn clockwise."""
    film(tmp_path / "a.mp4", STAMPS[:4])
    plain = list(read_frames(tmp_path / "a.mp4"))
    tag_as_turned(tmp_path / "a.mp4")
    video = describe_video(tmp_path / "a.mp4")
    shown = list(read_frames(tmp_path / "a.mp4"))
    assert (video.width, video.height) == (64, 96)
    for a, b in zip(plain, shown, strict=True):
        np.testing.assert_array_equal(b.grey, np.rot90(a.grey, -1))


def test_a_camera_of_pictures_without_the_tag_is_none_of_a_turned_video(tmp_path: Path) -> None:
    """It was said to be of another size, and asked for pictures of the size that they had; of a half turn nothing was said."""
    film(tmp_path / "a.mp4", STAMPS[:4])
    as_delivered = replace(camera(), width=96, height=64)
    refuse_other_size(describe_video(tmp_path / "a.mp4"), as_delivered)
    tag_as_turned(tmp_path / "a.mp4")
    with pytest.raises(
        Refused, match="tagged as turned by 90 deg, and read so: the camera was calibrated at 96x64, of pictures"
    ):
        refuse_other_size(describe_video(tmp_path / "a.mp4"), as_delivered)
    film(tmp_path / "b.mp4", STAMPS[:4])
    assert not any("tagged" in said for said in describe_video(tmp_path / "b.mp4").warnings)
    tag_as_turned(tmp_path / "b.mp4", half=True)
    assert any("tagged as turned by 180 deg" in said for said in describe_video(tmp_path / "b.mp4").warnings)


def test_segments_begin_at_key_frames_and_hold_every_frame_once(tmp_path: Path) -> None:
    """Decoded alone and in any order they give the frames of the whole to the last bit, B-frames or none."""
    for name, options in (("p.mp4", {"bf": "0"}), ("b.mp4", {"bf": "3", "x264-params": "open-gop=1"})):
        path = film(tmp_path / name, [3000 * k for k in range(700)], options={"g": "50", **options})
        video = describe_video(path)
        assert len(video.segments) == 3
        assert [s.first_index for s in video.segments] == np.cumsum(
            [0, *(s.count for s in video.segments[:-1])]
        ).tolist()
        alone = [frame for s in reversed(video.segments) for frame in reversed(list(read_segment(video, s)))][::-1]
        whole = list(read_frames(path))
        assert [f.index for f in alone] == [f.index for f in whole] == list(range(700))
        with av.open(str(path)) as container:
            for a, picture in zip(alone, container.decode(video=0), strict=True):
                assert a.time == picture.time
                np.testing.assert_array_equal(a.grey, picture.to_ndarray()[:64])


def test_a_frame_lost_within_is_missed(tmp_path: Path) -> None:
    """Zeroes over a packet in the middle: named as damage, not passed over."""
    data = bytearray(film(tmp_path / "a.mp4", STAMPS).read_bytes())
    with av.open(str(tmp_path / "a.mp4")) as container:
        places = [(e.pos, e.size) for e in container.streams.video[0].index_entries]
    at, size = places[20]
    data[at : at + size] = bytes(size)
    (tmp_path / "a.mp4").write_bytes(data)
    with pytest.raises(Refused, match=r"damaged"):
        list(read_frames(tmp_path / "a.mp4"))
