"""Frames of a recorded video with their own time stamps; damage is named, not passed over.

PyAV gives exact stamps in every container. Pictures are the luma plane, (height, width) uint8.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import av
import av.error
import numpy as np
from numpy.typing import NDArray

from vision.video_file import open_video, refuse_incomplete, videos_in
from vision.video_packets import packet_stamps
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import FileIdentity, file_identity, refuse_changed

Grey = NDArray[np.uint8]
MIN_SEGMENT_S = 10.0
"""s: least length of a piece of video that one process works on, from a key frame to a later one"""
LONG_GAP_S = 1.0
"""s: a longer time from one frame to the next is named in a warning (docs/thresholds.md)"""


@dataclass(frozen=True)
class Segment:
    """Consecutive frames of a video that begin with a key frame."""

    first_index: int
    """number of the frames before it in the video"""
    count: int
    """number of its frames"""
    first_stamp: int
    """presentation stamp of its key frame, in ticks"""
    end_stamp: int | None
    """presentation stamp of the next segment's key frame, in ticks; None for the last segment"""


@dataclass(frozen=True)
class Video:
    """A video as its packets describe it; width and height are those of the upright picture, px."""

    path: Path
    identity: FileIdentity
    """of the file that was described: the frames are read from the same one"""
    width: int
    height: int
    frames: int
    """number of frames"""
    quarter_turns: int
    """counter-clockwise, as the rotation tag asks for, 0..3"""
    segments: tuple[Segment, ...]
    warnings: tuple[str, ...]
    """sentences on what is unusual in the file, though it can be read"""


@dataclass(frozen=True)
class FirstPicture:
    """What the first picture that can be decoded says of all."""

    stamp: int
    """presentation stamp, in ticks"""
    quarter_turns: int
    interlaced: bool


@dataclass(frozen=True)
class Frame:
    """A decoded picture: position in the file from 0, time on the camera's clock in s, grey levels."""

    index: int
    time: float
    grey: Grey


def describe_video(path: str | Path) -> Video:
    """A video's size, number of frames and segments, without decoding more than its first frame.

    Raises Refused for a missing file, one that is no video, one without time stamps or with such that go back, and one that ends
    before its container says.
    """
    path = Path(path)
    identity = file_identity(path)
    container, stream = open_video(path)
    with container:
        refuse_incomplete(path)
        packets = packet_stamps(path, container, stream)
        tick, width, height = float(stream.time_base or 0), stream.width, stream.height
        number_of_videos = len(videos_in(container))
        seekable = (
            container.format.name != "mpegts"
        )  # without an index FFmpeg finds a place near a key frame, or beyond it
    # an edit list hides frames that are decoded for the sake of later ones: cuts without loss have some at their beginning
    stamps = sorted(p.stamp for p in packets if not p.hidden)
    first = _first_picture(path)
    undecodable = int(np.searchsorted(stamps, first.stamp))
    if undecodable and first.stamp > next(p.stamp for p in packets if p.is_key):
        raise Refused(path, f"is damaged: its first {undecodable} frames cannot be decoded", "copy the file again")
    stamps = stamps[undecodable:]
    keys = [p.stamp for p in packets if p.is_key and not p.hidden and seekable]
    if first.quarter_turns % 2:
        width, height = height, width
    return Video(
        path=path,
        identity=identity,
        width=width,
        height=height,
        frames=len(stamps),
        quarter_turns=first.quarter_turns,
        segments=_segments(stamps, keys, tick),
        warnings=_warnings(number_of_videos, undecodable, first, np.array(stamps) * tick),
    )


def read_frames(path: str | Path) -> Iterator[Frame]:
    """All frames in order, in one pass; memory holds one at a time. Raises Refused as `describe_video` and `read_segment` do."""
    yield from read_segments(describe_video(path))


def read_segments(video: Video) -> Iterator[Frame]:
    """All frames of a described video in order. Raises Refused as `read_segment` does."""
    for segment in video.segments:
        yield from read_segment(video, segment)


def read_segment(video: Video, segment: Segment) -> Iterator[Frame]:
    """Frames of one segment; they do not depend on whether those before it were decoded.

    Raises Refused where a frame is damaged or missing, has another size, or a stamp that does not increase, and where the file
    is not the one that was described, or is changed meanwhile.
    """
    refuse_changed(video.path, video.identity)
    try:
        yield from _decoded_frames(video, segment)
    except Refused:
        refuse_changed(video.path, video.identity)  # a file that is being written to looks damaged
        raise
    refuse_changed(video.path, video.identity)


def _decoded_frames(video: Video, segment: Segment) -> Iterator[Frame]:
    path, count, last = video.path, 0, -np.inf
    container, stream = open_video(path)
    with container:
        stream.thread_type = "AUTO"
        try:
            if segment.first_index:
                container.seek(segment.first_stamp, stream=stream)
            for picture in container.decode(stream):
                at = segment.first_index + count
                if picture.pts is None or picture.time_base is None:
                    raise Refused(path, f"frame {at} has no time stamp", "record into mp4 or mkv")
                if picture.pts < segment.first_stamp:
                    continue  # shown earlier than the key frame with which the decoder began: it belongs to the segment before
                if segment.end_stamp is not None and picture.pts >= segment.end_stamp:
                    break
                if picture.is_corrupt:
                    raise Refused(path, f"frame {at} is damaged", "copy the file again, or record again")
                time = float(picture.pts * picture.time_base)
                if time <= last:
                    raise _not_later(path, at, time, container.format.name)
                grey = upright(picture, video.quarter_turns)
                if grey.shape != (video.height, video.width):
                    size = f"{grey.shape[1]}x{grey.shape[0]}, those before it are {video.width}x{video.height}"
                    raise Refused(path, f"frame {at} is {size}", "give each part by itself")
                yield Frame(at, time, grey)
                last = time
                count += 1
        except av.error.FFmpegError as error:
            at = segment.first_index + count
            raise Refused(path, f"is damaged after frame {at} ({error.strerror})", "copy the file again") from error
    if count != segment.count:
        at = segment.first_index + count
        raise Refused(
            path, f"is damaged: {segment.count - count} frames are missing before frame {at}", "copy it again"
        )


def _not_later(path: Path, at: int, time: float, container: str) -> Refused:
    """Why frames in the order of decoding are not in the order of time."""
    what = f"frame {at} is not later than the one before ({time:.4f} s)"
    if container == "avi":
        return Refused(path, f"{what}: AVI cannot hold the stamps of B-frames", "record into mp4 or mkv")
    return Refused(path, what)


def _warnings(videos: int, undecodable: int, first: FirstPicture, time: NDArray[np.float64]) -> tuple[str, ...]:
    """Sentences on a file with so many video streams and frames before its first key frame, and with frames at times (F,), s."""
    warnings = []
    if videos > 1:
        warnings.append(f"of the {videos} videos in the file the first one is read")
    if undecodable:
        warnings.append(f"the first {undecodable} frames need a key frame that is not in the file: they are left out")
    if first.quarter_turns == 2:
        warnings.append(
            "the video is tagged as turned by 180 deg, and read so: pictures are read without such tags, so that camera.yaml must "
            "be of a video that is tagged alike"
        )
    if first.interlaced:
        warnings.append(
            "the video is marked as interlaced: if it is, even and odd rows show two moments, and angles are off"
        )
    warnings += [
        f"no frame for {after - before:.1f} s after {before:.3f} s"
        for before, after in pairwise(time.tolist())
        if after - before > LONG_GAP_S
    ]
    return tuple(warnings)


def _segments(stamps: list[int], keys: list[int], tick: float) -> tuple[Segment, ...]:
    """Segments that begin at key frames, at least MIN_SEGMENT_S apart; the first one includes what precedes its key frame."""
    cuts = [stamps[0]]
    for key in keys:
        if (key - cuts[-1]) * tick >= MIN_SEGMENT_S:
            cuts.append(key)
    starts = np.searchsorted(stamps, cuts).tolist()
    segments = []
    for k, (first, before) in enumerate(zip(cuts, starts, strict=True)):
        last = k + 1 == len(cuts)
        count = (len(stamps) if last else starts[k + 1]) - before
        segments.append(Segment(before, count, first, None if last else cuts[k + 1]))
    return tuple(segments)


def _first_picture(path: Path) -> FirstPicture:
    """What the first decoded picture says. Raises Refused where there is none, or it must be turned or mirrored oddly."""
    container, stream = open_video(path)
    with container:
        try:
            picture = next(container.decode(stream), None)
        except av.error.FFmpegError as error:
            raise Refused(path, f"is damaged at its first frame ({error.strerror})", "copy the file again") from error
    if picture is None or picture.pts is None:
        raise Refused(path, "has no frame that can be decoded", "is it whole?")
    return first_picture_of(path, picture)


def first_picture_of(path: Path, picture: av.VideoFrame) -> FirstPicture:
    """What a decoded picture says of all. Raises Refused where it must be turned or mirrored oddly."""
    assert picture.pts is not None
    if picture.rotation % 90:
        raise Refused(path, f"is tagged as turned by {picture.rotation} deg", "only quarter turns are read")
    matrix = picture.side_data.get("DISPLAYMATRIX")
    if matrix is not None:
        a, b, _, c, d, *_ = struct.unpack("=9i", bytes(matrix))
        if a * d - b * c < 0:
            raise Refused(path, "is tagged as mirrored", "record without it: a marker's mirror image is no marker")
    return FirstPicture(picture.pts, picture.rotation // 90 % 4, picture.interlaced_frame)


def upright(picture: av.VideoFrame, quarter_turns: int) -> Grey:
    """Grey levels of a picture, turned as the rotation tag asks for, (height, width)."""
    return np.rot90(_luma(picture), quarter_turns)


def _luma(picture: av.VideoFrame) -> Grey:
    """The luma plane where the format has one, of more than 8 bits the upper 8; else a conversion."""
    form = picture.format
    bits = form.components[0].bits
    if (
        form.name.startswith(("yuv4", "yuva4", "yuvj4", "nv12", "gray"))
        and 8 <= bits <= 16
        and not form.name.endswith("be")
    ):
        plane = picture.planes[0]
        kind = np.uint8 if bits == 8 else np.uint16
        rows = np.frombuffer(plane, dtype=kind).reshape(-1, plane.line_size // np.dtype(kind).itemsize)  # type: ignore[arg-type]
        levels = rows[: picture.height, : picture.width]
        return np.asarray(levels if bits == 8 else levels >> (bits - 8), dtype=np.uint8)
    return picture.to_ndarray(format="gray").astype(np.uint8, copy=False)
