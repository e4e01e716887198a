"""Frames of a recorded video with their own time stamps; damage is named, not passed over.

PyAV gives exact stamps in every container. Pictures are the luma plane, (height, width) uint8.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import av.container
import av.error
import numpy as np
from numpy.typing import NDArray

from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input

Grey = NDArray[np.uint8]
CONTAINERS_WITHOUT_STAMPS = ("h264", "hevc", "m4v", "mjpeg")
MIN_SEGMENT_S = 10.0
"""s: least length of a piece of video that one process works on, from a key frame to a later one"""


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
    width: int
    height: int
    frames: int
    """number of frames"""
    quarter_turns: int
    """counter-clockwise, as the rotation tag asks for, 0..3"""
    segments: tuple[Segment, ...]


@dataclass(frozen=True)
class Frame:
    """A decoded picture: position in the file from 0, time on the camera's clock in s, grey levels."""

    index: int
    time: float
    grey: Grey


def describe_video(path: str | Path) -> Video:
    """A video's size, number of frames and segments, without decoding more than its first frame.

    Raises Refused for a missing file, one that is no video, one without time stamps, and one that ends before its index does.
    """
    path = Path(path)
    with _open(path) as container:
        stream = container.streams.video[0]
        try:
            # stamps only: the packets themselves are as large as the file
            packets = [(p.pts, p.is_keyframe) for p in container.demux(stream) if p.size and not p.is_discard]
        except av.error.FFmpegError as error:
            raise Refused(path, f"is damaged ({error.strerror})", "copy the file again") from error
        stamps = [pts for pts, _ in packets if pts is not None]
        if not packets:
            raise Refused(path, "has no frame")
        if len(stamps) < len(packets):
            raise Refused(path, "has frames without time stamps", "record into mp4 or mkv")
        indexed, tick = _indexed_frames(container), float(stream.time_base or 0)
        duration_s = (container.duration or 0) / av.time_base
        if (indexed and len(packets) < indexed) or (not indexed and duration_s - max(stamps) * tick > 1.0):
            raise Refused(path, f"is truncated: {len(packets)} frames are there", "copy the file again")
        keys = sorted(pts for pts, is_key in packets if is_key and pts is not None)
        width, height = stream.width, stream.height
    quarter_turns = _quarter_turns(path)
    if quarter_turns % 2:
        width, height = height, width
    return Video(
        path=path,
        width=width,
        height=height,
        frames=len(packets),
        quarter_turns=quarter_turns,
        segments=_segments(sorted(stamps), keys, tick),
    )


def read_frames(path: str | Path) -> Iterator[Frame]:
    """All frames in order, in one pass; memory holds one at a time. Raises Refused as `describe_video` and `read_segment` do."""
    video = describe_video(path)
    for segment in video.segments:
        yield from read_segment(video, segment)


def read_segment(video: Video, segment: Segment) -> Iterator[Frame]:
    """Frames of one segment; they do not depend on whether those before it were decoded.

    Raises Refused where a frame is damaged or missing, or has a stamp that does not increase.
    """
    path, count, last = video.path, 0, -np.inf
    with _open(path) as container:
        stream = container.streams.video[0]
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
                    raise Refused(path, f"frame {at} is not later than the one before ({time:.4f} s)")
                yield Frame(at, time, np.rot90(_luma(picture), video.quarter_turns))
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


def _quarter_turns(path: Path) -> int:
    """Quarter turns counter-clockwise that the first frame's display matrix asks for."""
    with _open(path) as container:
        try:
            picture = next(container.decode(container.streams.video[0]), None)
        except av.error.FFmpegError as error:
            raise Refused(path, f"is damaged at its first frame ({error.strerror})", "copy the file again") from error
    if picture is None:
        raise Refused(path, "has no frame that can be decoded", "is it whole?")
    if picture.rotation % 90:
        raise Refused(path, f"is tagged as turned by {picture.rotation} deg", "only quarter turns are read")
    return picture.rotation // 90 % 4


def _open(path: Path) -> av.container.InputContainer:
    check_input(path)
    try:
        container = av.open(str(path))
    except (av.error.FFmpegError, ValueError) as error:
        if _ends_early(path):
            raise Refused(path, "is truncated: its index is missing", "copy the file again, or record again") from error
        reason = getattr(error, "strerror", None) or str(error)
        raise Refused(path, f"is not a video that can be read ({reason})", "is it whole, and a video?") from error
    if not container.streams.video:
        container.close()
        raise Refused(path, "has no video in it")
    if container.format.name in CONTAINERS_WITHOUT_STAMPS:
        container.close()
        raise Refused(path, "is a bare stream without time stamps", "record into mp4 or mkv")
    return container


def _indexed_frames(container: av.container.InputContainer) -> int | None:
    """Number of frames that the container's index lists; None where it lists key frames only.

    The header's count is no substitute: AVI counts the slots of dropped frames too.
    """
    listing_all = {"mov", "mp4", "avi"} & set(container.format.name.split(","))
    return len(container.streams.video[0].index_entries) or None if listing_all else None


def _ends_early(path: Path) -> bool:
    """Whether an mp4's last box runs past the end of the file (ISO 14496-12: size and type lead every box)."""
    end, at = path.stat().st_size, 0
    with path.open("rb") as stream:
        while at < end:
            stream.seek(at)
            head = stream.read(16)
            if len(head) < 8 or (at == 0 and head[4:8] != b"ftyp"):
                return at > 0
            size = int.from_bytes(head[:4], "big")
            size = int.from_bytes(head[8:16], "big") if size == 1 else size or end - at
            if size < 8:
                return False
            at += size
    return at > end


def _luma(picture: av.VideoFrame) -> Grey:
    """The luma plane where the format has one of 8 bits, else a conversion."""
    name = picture.format.name
    if name.startswith(("yuv4", "yuvj4", "nv12", "gray")) and picture.format.components[0].bits == 8:
        plane = picture.planes[0]
        rows = np.frombuffer(plane, dtype=np.uint8).reshape(-1, plane.line_size)  # type: ignore[arg-type]
        return rows[: picture.height, : picture.width]
    return picture.to_ndarray(format="gray").astype(np.uint8, copy=False)
