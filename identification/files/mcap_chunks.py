"""The records in a chunk of an MCAP file, with bounds on its unpacked size."""

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Schema

MAX_CHUNK_BYTES = 1 << 28
"""bytes that a chunk may unpack to; writers close one at some MB, or after one message that is larger (docs/thresholds.md)"""
MAX_UNPACKING_RATIO = 200
"""largest ratio of a file's unpacked to its packed size (docs/thresholds.md)"""
PREFIX = struct.Struct("<BQ")
"""opcode and length, before every record"""

_MESSAGE = struct.Struct("<HIQQ")


def unpacked_chunk(chunk: Chunk) -> bytes:
    """Bytes of a chunk's records.

    Raises one of the errors that libraries raise on damaged bytes, or ValueError with words about the chunk, where it is damaged,
    is not of the size that it states, or is larger than MAX_CHUNK_BYTES.
    """
    size = chunk.uncompressed_size
    if size > MAX_CHUNK_BYTES:
        raise ValueError(f"says that it unpacks to {size / (1 << 30):.1f} GiB")
    if chunk.compression == "zstd":
        if zstandard.frame_content_size(chunk.data) not in (size, -1):
            raise ValueError("does not unpack to the size that it says")
        data = zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=size)
    elif chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise ValueError(f"is packed by {chunk.compression[:20]!r}")
    if len(data) != size:
        raise ValueError("does not unpack to the size that it says")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise ValueError("fails its checksum")
    return data


def records_in(data: bytes) -> Iterator[Schema | Channel | Message]:
    """Schemas, channels and messages: a chunk holds nothing else. Raises the same errors as `unpacked_chunk`."""
    at = 0
    while at < len(data):
        opcode, length = PREFIX.unpack_from(data, at)
        at += PREFIX.size
        content = data[at : at + length]
        at += length
        if at > len(data):
            raise ValueError("ends within a record")
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(content)
            yield Message(channel, log_time, content[_MESSAGE.size :], publish_time, sequence)
        elif opcode == Opcode.CHANNEL:
            yield Channel.read(ReadDataStream(BytesIO(content)))
        elif opcode == Opcode.SCHEMA:
            yield Schema.read(ReadDataStream(BytesIO(content)))
        else:
            raise ValueError("holds what belongs in no chunk")
