"""The frames of a video that is being written, and the segments that `vision.video` will cut it into once it is finished.

Matroska, MPEG-TS and fragmented mp4 can be read so; a plain mp4 has its index at its end, and cannot be read before that is there.
"""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import av.error
from av.packet import Packet

from vision.container_layout import index_comes_last
from vision.video import MIN_SEGMENT_S, Frame, first_picture_of, upright
from vision.video_file import CONTAINERS, open_video, refusal_of, videos_in
from xneck.watch.growing_file import GrowingFile
from xneck_foundation.errors import Refused

_OPTIONS = {"format_whitelist": ",".join(CONTAINERS)}


@dataclass(frozen=True)
class GrowingFrame:
    """A frame, and the segment that it is in."""

    frame: Frame
    segment_stamp: int
    """presentation stamp of the segment's first frame, in ticks"""


class GrowingVideo:
    """A video as far as it is written."""

    def __init__(self, path: Path, source: GrowingFile) -> None:
        self.path, self._source = path, source
        self.size: tuple[int, int] | None = None
        """width and height of the upright picture, px, once a frame was read"""
        self._digest = hashlib.blake2b()
        self._packets = 0
        self._first_s: float | None = None

    @property
    def wait_for_end(self) -> bool | None:
        """Whether it can be read only when it is finished; None where it cannot be told yet."""
        return index_comes_last(self.path) if self.path.is_file() else None

    def frames(self) -> Iterator[GrowingFrame]:
        """All frames in order, as they come, until the source ends. Raises Refused where it is damaged or no video."""
        try:
            container = av.open(self._source, "r", container_options=_OPTIONS, metadata_errors="replace")
        except (av.error.FFmpegError, ValueError) as error:
            raise refusal_of(self.path, getattr(error, "strerror", None) or str(error)) from error
        count = 0
        with container:
            streams = videos_in(container)
            if not streams:
                raise Refused(self.path, "has no video in it", "is it the right file?")
            stream = streams[0]
            stream.thread_type = "SLICE"  # threads by frames would keep some back
            tick, seekable = float(stream.time_base or 0), container.format.name != "mpegts"
            cuts: list[int] = []
            turns = 0
            try:
                for packet in container.demux(stream):
                    self._note(packet)
                    if cuts and seekable and _begins_segment(packet, cuts[-1], tick):
                        cuts.append(packet.pts or 0)
                    for picture in packet.decode():
                        if picture.pts is None:
                            raise Refused(self.path, "has frames without time stamps", "record into mkv")
                        if not cuts:
                            turns = first_picture_of(self.path, picture).quarter_turns
                            cuts.append(picture.pts)
                        grey = upright(picture, turns)
                        self.size = (grey.shape[1], grey.shape[0])
                        begun = max(cut for cut in cuts if cut <= picture.pts or cut == cuts[0])
                        time = float(picture.pts * stream.time_base) if stream.time_base else 0.0
                        self._first_s = time if self._first_s is None else self._first_s
                        yield GrowingFrame(Frame(count, time, grey), begun)
                        count += 1
            except av.error.FFmpegError as error:
                raise Refused(
                    self.path, f"is damaged after frame {count} ({error.strerror})", "record again"
                ) from error

    def seconds_behind(self, time: float) -> float:
        """By how much the frame at `time`, s, is older than the newest one in the file, by the bytes between them."""
        read = self._source.position
        if self._first_s is None or read == 0:
            return 0.0
        return (self._source.size - read) / read * (time - self._first_s)

    def is_still_the_same(self) -> bool:
        """Whether the finished file begins with the packets that were read: a header may be written anew, pictures may not."""
        digest, count = hashlib.blake2b(), 0
        try:
            container, stream = open_video(self.path)
            with container:
                for packet in container.demux(stream):
                    if count == self._packets:
                        break
                    if packet.size:
                        _add(digest, packet)
                        count += 1
        except (Refused, av.error.FFmpegError):
            return False
        return count == self._packets and digest.digest() == self._digest.digest()

    def _note(self, packet: Packet) -> None:
        if packet.size:
            _add(self._digest, packet)
            self._packets += 1


def _begins_segment(packet: Packet, last: int, tick: float) -> bool:
    """Whether a packet begins a segment, as `vision.video` cuts a finished video; last: stamp of the segment's before, in ticks."""
    return packet.is_keyframe and packet.pts is not None and (packet.pts - last) * tick >= MIN_SEGMENT_S


def _add(digest: "hashlib.blake2b", packet: Packet) -> None:
    digest.update(f"{packet.pts} ".encode() + bytes(packet))
