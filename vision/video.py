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

from xneck.errors import Refused

Grey = NDArray[np.uint8]
CONTAINERS_WITHOUT_STAMPS = ("h264", "hevc", "m4v", "mjpeg")


@dataclass(frozen=True)
class Video:
    """What a video says of itself; `frames` is its index's count, None where the container has no index."""

    path: Path
    width: int
    height: int
    frames: int | None
    rate: float | None


@dataclass(frozen=True)
class Frame:
    """A decoded picture: position in the file from 0, time on the camera's clock in s, grey levels."""

    index: int
    time: float
    grey: Grey


def describe(path: str | Path) -> Video:
    """A video's size and count. Raises Refused where it is missing, no video, or has no time stamps."""
    path = Path(path)
    with _open(path) as container:
        stream = container.streams.video[0]
        rate = float(stream.average_rate) if stream.average_rate else None
        return Video(path, stream.width, stream.height, _indexed(container), rate)


def frames(path: str | Path) -> Iterator[Frame]:
    """All frames in order, one pass, flat in memory.

    Raises Refused where a frame is damaged, has no stamp or a stamp that does not increase, or where the file ends
    before the last frame that its index names.
    """
    path = Path(path)
    count, last = 0, -np.inf
    with _open(path) as container:
        stream = container.streams.video[0]
        stream.thread_type = "AUTO"
        expected = _indexed(container)
        try:
            for picture in container.decode(stream):
                if picture.pts is None or picture.time_base is None:
                    raise Refused(path, f"frame {count} has no time stamp", "record into mp4 or mkv")
                if picture.is_corrupt:
                    raise Refused(path, f"frame {count} is damaged", "copy the file again, or record again")
                time = float(picture.pts * picture.time_base)
                if time <= last:
                    raise Refused(path, f"frame {count} is not later than the one before ({time:.4f} s)")
                yield Frame(count, time, _luma(picture))
                last = time
                count += 1
        except av.error.FFmpegError as error:
            raise Refused(path, f"is damaged after frame {count} ({error.strerror})", "copy the file again") from error
    if count == 0:
        raise Refused(path, "has no frame")
    if expected and count < expected:
        raise Refused(path, f"is truncated: {count} of {expected} frames are there", "copy the file again")


def _open(path: Path) -> av.container.InputContainer:
    if not path.is_file():
        raise Refused(path, "is a folder" if path.is_dir() else "does not exist", "name a video file")
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
