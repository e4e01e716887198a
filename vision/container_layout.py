"""What the outer boxes of a container say of the file: cut short, several videos joined, or pictures kept in another file."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

MP4_BEGINNINGS = (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip", b"pnot")
"""kinds of box with which an mp4 or mov may begin"""
_LARGE = (b"moov", b"mdat", b"moof")
"""boxes that hold a video; what other programs append after them may be of any form"""
_MATROSKA = b"\x1aE\xdf\xa3"
_SEGMENT = b"\x18S\x80g"
"""element that holds all of a Matroska video (RFC 9559, 5.1)"""
_UNKNOWN_RIFF_BYTES = (0, 0xFFFF_FFFF)
"""sizes of an AVI whose recorder was stopped before it knew its size"""
_MAX_HEADER_BYTES = 4096
"""a Matroska header is some 40 bytes"""


@dataclass(frozen=True)
class _Box:
    """A box of an mp4 or mov (ISO 14496-12, 4.2): its kind, and where its content begins and it ends, in bytes."""

    kind: bytes
    content: int
    end: int


def truncation(path: Path) -> str | None:
    """What shows that an mp4, mov, AVI or Matroska file was cut short; None where nothing does. Raises OSError."""
    size, longer = path.stat().st_size, "it says that it is longer"
    with path.open("rb") as stream:
        head = stream.read(12)
        if head[:4] == b"RIFF":
            stated = int.from_bytes(head[4:8], "little")
            return longer if stated not in _UNKNOWN_RIFF_BYTES and stated + 8 > size else None
        if head[:4] == _MATROSKA:
            end = _segment_end(stream)
            return longer if end is not None and end > size else None
        if head[4:8] not in MP4_BEGINNINGS:
            return None
        boxes = list(_boxes(stream, 0, size))
        if all(box.kind != b"moov" for box in boxes):
            return "its index is missing"
        return longer if any(box.end > size for box in boxes if box.kind in _LARGE) else None


def index_comes_last(path: Path) -> bool | None:
    """Whether an mp4 or mov holds pictures before its index, so that it cannot be read before it is finished; None where it cannot
    be told yet. False for other files. Raises OSError."""
    with path.open("rb") as stream:
        head = stream.read(12)
        if len(head) < 12:
            return None
        if head[4:8] not in MP4_BEGINNINGS:
            return False
        for box in _boxes(stream, 0, path.stat().st_size):
            if box.kind in (b"moov", b"mdat"):
                return box.kind == b"mdat"
    return None


def is_joined(path: Path) -> bool:
    """Whether a second mp4 or Matroska video follows the first in the same file. Raises OSError."""
    size = path.stat().st_size
    with path.open("rb") as stream:
        head = stream.read(12)
        if head[:4] == _MATROSKA:
            end = _segment_end(stream)
            if end is None or end >= size:
                return False
            stream.seek(end)
            return stream.read(4) == _MATROSKA
        return head[4:8] == b"ftyp" and [box.kind for box in _boxes(stream, 0, size)].count(b"ftyp") > 1


def names_other_file(path: Path) -> bool:
    """Whether a track of an mp4 or mov says that its pictures lie in another file (ISO 14496-12, 8.7.2). Raises OSError."""
    with path.open("rb") as stream:
        ways = [_Box(b"", 0, path.stat().st_size)]
        for kind in (b"moov", b"trak", b"mdia", b"minf", b"dinf", b"dref"):
            ways = [box for way in ways for box in _boxes(stream, way.content, way.end) if box.kind == kind]
        # after version, flags and count, an entry is a box with flags of its own; without the first of them it names a file
        return any(
            not _flags(stream, entry) & 1 and entry.end > entry.content + 5
            for way in ways
            for entry in _boxes(stream, way.content + 8, way.end)
        )


def _boxes(stream: BinaryIO, begin: int, end: int) -> Iterator[_Box]:
    """The boxes from byte `begin` to `end`; the last may reach beyond. Ends where something is no box."""
    while begin + 8 <= end:
        stream.seek(begin)
        head = stream.read(16)
        size, content = int.from_bytes(head[:4], "big"), begin + 8
        if size == 1:
            size, content = int.from_bytes(head[8:16], "big"), begin + 16
        elif size == 0:
            size = end - begin
        if size < 8:
            return
        yield _Box(head[4:8], content, begin + size)
        begin += size


def _flags(stream: BinaryIO, box: _Box) -> int:
    """The flags of a full box."""
    stream.seek(box.content)
    return int.from_bytes(stream.read(4), "big") & 0xFF_FFFF


def _segment_end(stream: BinaryIO) -> int | None:
    """Where a Matroska file's first segment says it ends, in bytes; None where it does not say."""
    stream.seek(0)
    head = stream.read(_MAX_HEADER_BYTES)
    at = head.find(_SEGMENT)
    if at < 0 or at + 4 >= len(head):
        return None
    first = head[at + 4]
    width = 9 - first.bit_length()  # the leading zeroes count the further bytes of the size (RFC 8794, 4)
    if not first or at + 4 + width > len(head):
        return None
    bits = 7 * width
    size = int.from_bytes(head[at + 4 : at + 4 + width], "big") & ((1 << bits) - 1)
    return None if size == (1 << bits) - 1 else at + 4 + width + size
