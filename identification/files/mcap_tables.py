"""MCAP written from tables: the messages of a channel all have one size, and go into a chunk together.

But for the packing's level the bytes are those that mcap.writer.Writer makes of the same messages one by one.
"""

import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from numpy.typing import NDArray

from identification.files.mcap_chunks import PREFIX
from identification.files.mcap_index import MAGIC

CHUNK_BYTES = 1 << 18
"""bytes of rows that share a checksum and are lost together, a seventh of a second of a data set"""

COMPRESSION_LEVEL = -1
"""of zstd: a third of the default's time, for files that are 5 to 7 % larger"""

_ROWS_INTERLEAVED = 20_000
"""rows of the longest channel whose order is worked out at once"""
_COMPRESSION = "zstd"
_MESSAGE_HEAD = [
    ("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("logged", "<u8"), ("published", "<u8"),
]  # fmt: skip
_HEAD_BYTES = np.dtype(_MESSAGE_HEAD).itemsize
_INDEX_HEAD = struct.Struct("<HI")
_INDEX_ENTRY = np.dtype([("logged", "<u8"), ("offset", "<u8")])
_CHECKSUM_BYTES = 4


@dataclass(frozen=True)
class MessageTable:
    """The messages of a channel, T rows of one size."""

    topic: str
    """with its slash"""
    logged: NDArray[np.int64]
    """(T,), ns"""
    published: NDArray[np.int64]
    size: int
    """bytes of a message"""
    rows: Callable[[slice], NDArray[np.uint8]]
    """makes some of the messages, (rows, size)"""

    def records(self, channel: int, part: slice) -> list[bytes]:
        """Some of the messages as a file holds them."""
        messages = np.ascontiguousarray(self.rows(part))
        records = np.empty(len(messages), dtype=np.dtype([*_MESSAGE_HEAD, ("message", f"V{self.size}")]))
        records["opcode"], records["channel"] = Opcode.MESSAGE, channel
        records["length"] = records.itemsize - PREFIX.size
        records["sequence"] = np.arange(part.start, part.start + len(messages))
        records["logged"], records["published"] = self.logged[part], self.published[part]
        records["message"] = messages.view(f"V{self.size}")[:, 0]
        return records.view(f"V{records.itemsize}").tolist()


@dataclass(frozen=True)
class FileHead:
    """What stands before the messages."""

    profile: str
    library: str
    schema: Schema
    """of all channels"""
    encoding: str
    """of all messages"""
    metadata: Mapping[str, dict[str, str]]
    attachments: Mapping[str, tuple[str, bytes]]
    """media type and content by name"""


def write_tables(stream: BinaryIO, head: FileHead, tables: Sequence[MessageTable]) -> None:
    """A whole file; the channels' messages interleave so that all are equally far along wherever the file is cut off."""
    channels = [
        Channel(id=c, topic=table.topic, message_encoding=head.encoding, schema_id=head.schema.id, metadata={})
        for c, table in enumerate(tables, 1)
    ]
    stream.write(MAGIC + _bytes_of([Header(head.profile, head.library)]))
    metadata = [_add_metadata(stream, name, value) for name, value in head.metadata.items()]
    attachments = [_add_attachment(stream, name, *content) for name, content in head.attachments.items()]
    chunks, counts = list[McapRecord](), Counter[int]()
    compressor = zstandard.ZstdCompressor(level=COMPRESSION_LEVEL)
    for content in _chunks(tables, _bytes_of([head.schema, *channels])):
        chunks.append(_add_chunk(stream, content, compressor))
        counts.update({channel: len(index) for channel, index in content.index.items()})
    stream.write(_bytes_of([DataEnd(0)]))
    times = [table.logged for table in tables if len(table.logged)]
    statistics = Statistics(
        attachment_count=len(attachments),
        channel_count=len(channels),
        channel_message_counts=counts,
        chunk_count=len(chunks),
        message_count=counts.total(),
        message_end_time=max((int(logged.max()) for logged in times), default=0),
        message_start_time=min((int(logged.min()) for logged in times), default=0),
        metadata_count=len(metadata),
        schema_count=1,
    )
    groups: dict[Opcode, Sequence[McapRecord]] = {
        Opcode.SCHEMA: [head.schema],
        Opcode.CHANNEL: channels,
        Opcode.STATISTICS: [statistics],
        Opcode.CHUNK_INDEX: chunks,
        Opcode.ATTACHMENT_INDEX: attachments,
        Opcode.METADATA_INDEX: metadata,
    }
    _add_summary(stream, groups)


@dataclass(frozen=True)
class _ChunkContent:
    data: bytes
    index: dict[int, NDArray[np.void]]
    """_INDEX_ENTRY of each message by its channel"""


def _chunks(tables: Sequence[MessageTable], descriptions: bytes) -> Iterator[_ChunkContent]:
    """What chunks hold; the first one begins with `descriptions`, of schemas and channels."""
    sizes = np.array([_HEAD_BYTES + table.size for table in tables], dtype=np.int64)
    done = [0] * len(tables)
    for of_chunk in _chunk_channels(_interleaved([len(table.logged) for table in tables]), sizes, len(descriptions)):
        offsets = len(descriptions) + np.cumsum(sizes[of_chunk]) - sizes[of_chunk]
        records, index = list[Iterator[bytes]](), dict[int, NDArray[np.void]]()
        for c, table in enumerate(tables):
            at = np.flatnonzero(of_chunk == c)
            part = slice(done[c], done[c] + len(at))
            done[c] = part.stop
            records.append(iter(table.records(c + 1, part)))
            index[c + 1] = np.empty(len(at), dtype=_INDEX_ENTRY)
            index[c + 1]["logged"], index[c + 1]["offset"] = table.logged[part], offsets[at]
        order = of_chunk.tolist()
        data = b"".join([next(records[c]) for c in order])
        yield _ChunkContent(descriptions + data, {c + 1: index[c + 1] for c in dict.fromkeys(order)})
        descriptions = b""


def _chunk_channels(
    pieces: Iterator[NDArray[np.intp]], sizes: NDArray[np.int64], begin_byte: int
) -> Iterator[NDArray[np.intp]]:
    """The messages' channels, chunk by chunk: one ends with the message that exceeds it. begin_byte: bytes before the first."""
    waiting = np.empty(0, dtype=np.intp)
    for piece in pieces:
        waiting = np.concatenate([waiting, piece])
        ends = begin_byte + np.cumsum(sizes[waiting])
        done, done_byte = 0, 0
        while (end := int(np.searchsorted(ends, done_byte + CHUNK_BYTES, side="right")) + 1) <= len(waiting):
            yield waiting[done:end]
            done, done_byte = end, int(ends[end - 1])
            begin_byte = 0
        waiting = waiting[done:]
    if len(waiting):
        yield waiting


def _interleaved(counts: Sequence[int]) -> Iterator[NDArray[np.intp]]:
    """Channels of all messages in their order, in pieces.

    Channels of `counts` messages are interleaved so that all are equally far along.
    """
    longest = max(counts, default=0)
    begins = [0] * len(counts)
    for piece_end in range(_ROWS_INTERLEAVED, longest + _ROWS_INTERLEAVED, _ROWS_INTERLEAVED):
        # row i of n is (i + 1/2) / n along; here are those before piece_end / longest
        ends = [min(n, (2 * piece_end * n + longest - 1) // (2 * longest)) for n in counts]
        share = np.concatenate(
            [(np.arange(b, e) + 0.5) / max(n, 1) for b, e, n in zip(begins, ends, counts, strict=True)]
        )
        channel = np.repeat(np.arange(len(counts)), np.subtract(ends, begins))
        yield channel[np.argsort(share, kind="stable")]
        begins = ends


def _add_chunk(stream: BinaryIO, content: _ChunkContent, compressor: zstandard.ZstdCompressor) -> ChunkIndex:
    times = np.concatenate([index["logged"] for index in content.index.values()])
    chunk = Chunk(
        compression=_COMPRESSION,
        data=compressor.compress(content.data),
        message_start_time=int(times.min()),
        message_end_time=int(times.max()),
        uncompressed_crc=zlib.crc32(content.data),
        uncompressed_size=len(content.data),
    )
    start, record = stream.tell(), _bytes_of([chunk])
    stream.write(record)
    index_start, offsets = stream.tell(), dict[int, int]()
    for channel, index in content.index.items():
        offsets[channel] = stream.tell()
        body = _INDEX_HEAD.pack(channel, index.nbytes) + index.tobytes()
        stream.write(PREFIX.pack(Opcode.MESSAGE_INDEX, len(body)) + body)
    return ChunkIndex(
        message_start_time=chunk.message_start_time,
        message_end_time=chunk.message_end_time,
        chunk_start_offset=start,
        chunk_length=len(record),
        message_index_offsets=offsets,
        message_index_length=stream.tell() - index_start,
        compression=_COMPRESSION,
        compressed_size=len(chunk.data),
        uncompressed_size=chunk.uncompressed_size,
    )


def _add_metadata(stream: BinaryIO, name: str, value: dict[str, str]) -> MetadataIndex:
    offset, record = stream.tell(), _bytes_of([Metadata(name=name, metadata=value)])
    stream.write(record)
    return MetadataIndex(offset=offset, length=len(record), name=name)


def _add_attachment(stream: BinaryIO, name: str, kind: str, data: bytes) -> AttachmentIndex:
    attachment = Attachment(create_time=0, log_time=0, name=name, media_type=kind, data=data)
    offset, record = stream.tell(), _bytes_of([attachment])
    stream.write(record)
    return AttachmentIndex(
        offset=offset,
        length=len(record),
        create_time=0,
        log_time=0,
        data_size=len(data),
        name=name,
        media_type=kind,
    )


def _add_summary(stream: BinaryIO, groups: Mapping[Opcode, Sequence[McapRecord]]) -> None:
    """The summary, where its groups begin, and the file's end."""
    start, summary, places = stream.tell(), b"", list[SummaryOffset]()
    for opcode, records in groups.items():
        group = _bytes_of(records)
        places.append(SummaryOffset(opcode, group_start=start + len(summary), group_length=len(group)))
        summary += group
    places_start = start + len(summary)
    summary += _bytes_of(places)
    footer = Footer(summary_start=start, summary_offset_start=places_start, summary_crc=0)
    # the checksum covers the footer up to itself
    unsigned = _bytes_of([footer])[:-_CHECKSUM_BYTES]
    footer.summary_crc = zlib.crc32(summary + unsigned)
    stream.write(summary + _bytes_of([footer]) + MAGIC)


def _bytes_of(records: Sequence[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()
