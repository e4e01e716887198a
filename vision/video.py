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
SEGMENT_S = 10.0
"""s: about how much of a video is worked on as one piece, from a key frame to a later one"""


@dataclass(frozen=True)
class Segment:
    """Frames of a video from a key frame on: how many were before it, how many it has, and their stamps' range."""

    before: int
    count: int
    first: int
    """presentation stamp of its key frame, in ticks"""
    end: int | None
    """stamp of the next segment's key frame; None for the last"""


@dataclass(frozen=True)
class Video:
    """What a video holds, by its packets: size as shown (turned by its tag), frames, key frame to key frame."""

    path: Path
    width: int
    height: int
    frames: int
    turned: int
    """quarter turns counter-clockwise that its tag asks for"""
    segments: tuple[Segment, ...]


@dataclass(frozen=True)
class Frame:
    """A decoded picture: position in the file from 0, time on the camera's clock in s, grey levels."""

    index: int
    time: float
    grey: Grey


def describe(path: str | Path) -> Video:
    """A video's size, count and segments, without decoding more than its first frame.

    Raises Refused where it is missing, no video, without time stamps, or ends before its index does.
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
        indexed, tick = _indexed(container), float(stream.time_base or 0)
        shown_s = (container.duration or 0) / av.time_base
        if (indexed and len(packets) < indexed) or (not indexed and shown_s - max(stamps) * tick > 1.0):
            raise Refused(path, f"is truncated: {len(packets)} frames are there", "copy the file again")
        keys = sorted(pts for pts, is_key in packets if is_key and pts is not None)
        width, height = stream.width, stream.height
    turned = _turned(path)
    if turned % 2:
        width, height = height, width
    return Video(path, width, height, len(packets), turned, _segments(sorted(stamps), keys, tick))


def frames(path: str | Path) -> Iterator[Frame]:
    """All frames in order, one pass, flat in memory. Raises Refused as `describe` and `frames_of` do."""
    video = describe(path)
    for segment in video.segments:
        yield from frames_of(video, segment)


def frames_of(video: Video, segment: Segment) -> Iterator[Frame]:
    """Frames of one segment, the same whether those before it were decoded or not.

    Raises Refused where a frame is damaged or missing, or has a stamp that does not increase.
    """
    path, count, last = video.path, 0, -np.inf
    with _open(path) as container:
        stream = container.streams.video[0]
        stream.thread_type = "AUTO"
        try:
            if segment.before:
                container.seek(segment.first, stream=stream)
            for picture in container.decode(stream):
                at = segment.before + count
                if picture.pts is None or picture.time_base is None:
                    raise Refused(path, f"frame {at} has no time stamp", "record into mp4 or mkv")
                if picture.pts < segment.first:
                    continue  # of the segment before: shown earlier than the key frame that the decoder began with
                if segment.end is not None and picture.pts >= segment.end:
                    break
                if picture.is_corrupt:
                    raise Refused(path, f"frame {at} is damaged", "copy the file again, or record again")
                time = float(picture.pts * picture.time_base)
                if time <= last:
                    raise Refused(path, f"frame {at} is not later than the one before ({time:.4f} s)")
                yield Frame(at, time, np.rot90(_luma(picture), video.turned))
                last = time
                count += 1
        except av.error.FFmpegError as error:
            at = segment.before + count
            raise Refused(path, f"is damaged after frame {at} ({error.strerror})", "copy the file again") from error
    if count != segment.count:
        at = segment.before + count
        raise Refused(
            path, f"is damaged: {segment.count - count} frames are missing before frame {at}", "copy it again"
        )


def _segments(stamps: list[int], keys: list[int], tick: float) -> tuple[Segment, ...]:
    """Cuts at key frames, each at least SEGMENT_S after the one before; the first segment takes in what precedes its key."""
    cuts = [stamps[0]]
    for key in keys:
        if (key - cuts[-1]) * tick >= SEGMENT_S:
            cuts.append(key)
    starts = np.searchsorted(stamps, cuts).tolist()
    out = []
    for k, (first, before) in enumerate(zip(cuts, starts, strict=True)):
        last = k + 1 == len(cuts)
        count = (len(stamps) if last else starts[k + 1]) - before
        out.append(Segment(before, count, first, None if last else cuts[k + 1]))
    return tuple(out)


def _turned(path: Path) -> int:
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
        word = getattr(error, "strerror", None) or str(error)
        raise Refused(path, f"is not a video that can be read ({word})", "is it whole, and a video?") from error
    if not container.streams.video:
        container.close()
        raise Refused(path, "has no video in it")
    if container.format.name in CONTAINERS_WITHOUT_STAMPS:
        container.close()
        raise Refused(path, "is a bare stream without time stamps", "record into mp4 or mkv")
    return container


def _indexed(container: av.container.InputContainer) -> int | None:
    """How many frames the container's index lists; None where it lists key frames only.

    Headers' own counts are not it: AVI counts the slots of frames that were dropped.
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
