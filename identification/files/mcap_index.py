"""The index at an MCAP file's end: where its records begin, and when its messages were logged."""

import struct
import zlib
from pathlib import Path
from typing import BinaryIO

import zstandard
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.summary import Summary

from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input

MAGIC = b"\x89MCAP0\r\n"
DAMAGE_ERRORS = (
    McapError,
    zstandard.ZstdError,
    ValueError,
    struct.error,
    RuntimeError,
    EOFError,
    OverflowError,
    MemoryError,
)
"""errors that the libraries raise on damaged bytes; their checksum errors are ValueErrors"""

_FOOTER = struct.Struct("<BQQQI8s")


def read_summary(stream: BinaryIO, size: int) -> Summary | None:
    """The index at the file's end, None where it is missing or damaged."""
    if size < len(MAGIC) + _FOOTER.size:
        return None
    stream.seek(size - _FOOTER.size)
    opcode, _, start, _, crc, magic = _FOOTER.unpack(stream.read(_FOOTER.size))
    if opcode != Opcode.FOOTER or magic != MAGIC or not len(MAGIC) < start < size:
        return None
    stream.seek(start)
    if crc and zlib.crc32(stream.read(size - len(MAGIC) - 4 - start)) != crc:
        return None
    stream.seek(0)
    try:
        return make_reader(stream).get_summary()
    except DAMAGE_ERRORS:
        return None


def indexed_records(summary: Summary) -> dict[int, int]:
    """Opcodes of indexed records by where they begin, in the file's order."""
    places = {one.chunk_start_offset: int(Opcode.CHUNK) for one in summary.chunk_indexes}
    places |= {one.offset: int(Opcode.ATTACHMENT) for one in summary.attachment_indexes}
    places |= {one.offset: int(Opcode.METADATA) for one in summary.metadata_indexes}
    return dict(sorted(places.items()))


def chunks_outside(summary: Summary, within: tuple[int, int]) -> frozenset[int]:
    """Where chunks begin that hold no message logged from the first to the last of two times, ns."""
    first, last = within
    return frozenset(
        one.chunk_start_offset
        for one in summary.chunk_indexes
        if one.message_end_time < first or one.message_start_time > last
    )


def logged_span(path: Path) -> tuple[int, int] | None:
    """First and last log time of a file's messages, ns, by the index at its end; None where it has none, or no messages."""
    check_input(path)
    try:
        with path.open("rb") as stream:
            summary = read_summary(stream, path.stat().st_size) if stream.read(len(MAGIC)) == MAGIC else None
    except OSError as error:
        raise Refused(path, f"cannot be read ({error.strerror or error})") from error
    if summary is None or not summary.chunk_indexes:
        return None
    chunks = summary.chunk_indexes
    return min(one.message_start_time for one in chunks), max(one.message_end_time for one in chunks)
