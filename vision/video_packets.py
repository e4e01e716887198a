"""What the packets of a video say of its frames without being decoded: stamps, key frames, and whether any is missing."""

from dataclasses import dataclass
from pathlib import Path

import av.error
from av.container import InputContainer
from av.packet import Packet
from av.video.stream import VideoStream

from xneck_foundation.errors import Refused


@dataclass(frozen=True)
class PacketStamp:
    """What a packet says without being decoded."""

    stamp: int
    """presentation stamp, in ticks"""
    is_key: bool
    hidden: bool
    """whether the edit list leaves its frame out"""


def packet_stamps(path: Path, container: InputContainer, stream: VideoStream) -> list[PacketStamp]:
    """All packets in the order of decoding. Raises Refused where stamps are missing or go back, or packets are missing."""
    try:
        # stamps only: the packets themselves are as large as the file
        packets = [_packet_stamp(path, packet) for packet in container.demux(stream) if packet.size]
    except av.error.FFmpegError as error:
        raise Refused(path, f"is damaged ({error.strerror})", "copy the file again") from error
    if all(packet.hidden for packet in packets):
        raise Refused(path, "has no frame")
    indexed = _indexed_frames(container, stream)
    if indexed and len(packets) < indexed:
        raise Refused(path, f"is truncated: {len(packets)} of {indexed} frames are there", "copy the file again")
    latest, tick = packets[0].stamp, float(stream.time_base or 0)
    for packet in packets:
        # frames may be decoded before others that are shown earlier, but a key frame is shown after all that precede it
        if packet.is_key and packet.stamp < latest:
            back = f"from {latest * tick:.3f} to {packet.stamp * tick:.3f} s"
            raise Refused(
                path,
                f"its time stamps go back {back}, as where parts are joined end to end",
                "give each part by itself",
            )
        latest = max(latest, packet.stamp)
    return packets


def _packet_stamp(path: Path, packet: Packet) -> PacketStamp:
    if packet.pts is None:
        raise Refused(path, "has frames without time stamps", "record into mp4 or mkv")
    return PacketStamp(packet.pts, packet.is_keyframe, packet.is_discard)


def _indexed_frames(container: InputContainer, stream: VideoStream) -> int | None:
    """Number of frames that the container's index lists; None where it lists key frames only.

    The header's count is no substitute: AVI counts the slots of dropped frames too.
    """
    listing_all = {"mov", "mp4", "avi"} & set(container.format.name.split(","))
    return len(stream.index_entries) or None if listing_all else None
