"""The records of an MCAP file, as far as they are not damaged.

Every chunk and attachment has a checksum of its own, and our metadata too. What fails it is left out and named. Records are
found by their lengths alone: where one is wrong, the index at the file's end leads to the next; without it reading ends there.
"""

import json
import zlib
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, McapRecord, Message, Metadata, Schema

from identification.files.mcap_chunks import MAX_CHUNK_BYTES, MAX_UNPACKING_RATIO, PREFIX, records_in, unpacked_chunk
from identification.files.mcap_index import DAMAGE_ERRORS, MAGIC, chunks_outside, indexed_records, read_summary
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input

ROW_COUNTS_NAME = "rows"
"""name of the metadata with the number of rows that each channel was written with"""
_ENDS = {int(Opcode.DATA_END): 4, int(Opcode.FOOTER): 20}
"""lengths of records that end the data: a damaged opcode ends nothing"""
_KINDS = {
    int(Opcode.CHUNK): "a chunk",
    int(Opcode.ATTACHMENT): "the attachment",
    int(Opcode.METADATA): "the metadata",
}


MAX_HELD_MESSAGES = 4096
"""messages of a topic that are held before they are handed on, so that a file is never all in memory"""


@dataclass
class Topic:
    """A topic, with its messages that were not handed on yet, in the file's order."""

    schema: str
    encoding: str
    messages: list[bytes] = field(default_factory=list)
    written: int | None = None
    """number of messages that were written, where the file states it"""


@dataclass(frozen=True)
class Records:
    """Contents of a file: topics by name (without slash), JSON metadata and attachments by name; its damage, in words."""

    topics: dict[str, Topic]
    others: tuple[str, ...]
    """topics of other message types"""
    metadata: dict[str, Any]
    attached: dict[str, bytes]
    damage: tuple[str, ...]
    cut: bool
    """whether the file ends before its data do"""


def checksummed(name: str, value: Any) -> dict[str, str]:
    """Metadata as a file holds it: JSON, with a checksum, as MCAP gives metadata none."""
    text = json.dumps(value)
    return {"json": text, "crc32": _checksum(name, text)}


def read_records(
    path: Path, kind: str, take: Callable[[str, Topic], object], within: tuple[int, int] | None = None
) -> Records:
    """Messages whose schema's name ends in `kind`, and all metadata and attachments.

    take: is called with a topic's name and the topic whenever it holds MAX_HELD_MESSAGES, and at the file's end; the messages are
    dropped after it. within: first and last log time, ns; chunks that hold nothing between are passed over, where the file has an
    index.
    Raises Refused where the file is missing, not an MCAP, or where numbers without a checksum of their own are damaged.
    """
    check_input(path)
    try:
        with path.open("rb") as stream:
            return _Reading(path, stream, kind, within).records(take)
    except OSError as error:
        raise Refused(path, f"cannot be read ({error.strerror or error})") from error


class _Reading:
    """One pass through a file."""

    def __init__(self, path: Path, stream: BinaryIO, kind: str, within: tuple[int, int] | None = None) -> None:
        self.path, self.stream, self.kind = path, stream, kind
        self.size = path.stat().st_size
        if not self.size:
            raise Refused(path, "is empty", "copy it again, or record it again")
        if stream.read(len(MAGIC)) != MAGIC:
            raise Refused(path, "is not an MCAP file", "is it the right one, and copied as it was?")
        self.summary = read_summary(stream, self.size)
        self.passed_over = chunks_outside(self.summary, within) if self.summary and within else frozenset[int]()
        """where chunks begin that are not read"""
        self.channels: dict[int, Channel] = dict(self.summary.channels) if self.summary else {}
        self.schemas: dict[int, Schema] = dict(self.summary.schemas) if self.summary else {}
        self.topics: dict[str, Topic] = {}
        self.metadata: dict[str, Any] = {}
        self.attached: dict[str, bytes] = {}
        self.damage: list[str] = []
        self.nameless = 0
        """messages of channels that are described nowhere"""
        self.cut = False
        self.unpacked = 0
        """bytes of the chunks so far"""
        self.has_unchecked = False
        """whether there are messages that only the checksum over all data covers"""

    def records(self, take: Callable[[str, Topic], object]) -> Records:
        """All records that are not damaged."""

        def hand_on(min_messages: int) -> None:
            for name, topic in self.topics.items():
                if len(topic.messages) >= min_messages:
                    take(name, topic)
                    topic.messages.clear()

        for opcode, content, at in self._framed():
            try:
                self._take(opcode, content)
            except DAMAGE_ERRORS as error:
                self.damage.append(f"{_KINDS.get(opcode, 'a record')} at byte {at} {_why(error)}")
            hand_on(MAX_HELD_MESSAGES)
        hand_on(1)
        if self.nameless:
            self.damage.append(f"{self.nameless} messages are of channels whose description is lost")
        for name, count in ({} if self.passed_over else self._written()).items():
            if count and name not in self.topics:
                self.topics[name] = self._topic(next(c for c in self.channels.values() if _name(c) == name))
            if name in self.topics:
                self.topics[name].written = count
        wanted = {name: topic for name, topic in self.topics.items() if topic.schema.endswith(self.kind)}
        others = tuple(sorted(set(self.topics) - set(wanted)))
        return Records(
            topics=wanted,
            others=others,
            metadata=self.metadata,
            attached=self.attached,
            damage=tuple(self.damage),
            cut=self.cut,
        )

    def _framed(self) -> Iterator[tuple[int, bytes, int]]:
        """Opcode, content and place of one record after the other, up to the end of the data."""
        index = indexed_records(self.summary) if self.summary else {}
        places = list(index)
        at = len(MAGIC)
        crc: int | None = zlib.crc32(MAGIC)  # None once a record was passed over unread
        while True:
            self.stream.seek(at)
            prefix = self.stream.read(PREFIX.size)
            opcode, length = PREFIX.unpack(prefix) if len(prefix) == PREFIX.size else (0, self.size)
            after = at + PREFIX.size + length
            later = bisect_right(places, at)
            following = places[later] if later < len(places) else None
            if opcode == 0 or after > self.size or (following or after) < after or index.get(at, opcode) != opcode:
                if following is None:
                    self.cut = True
                    return
                kind = _KINDS.get(index.get(at, 0), "a record")
                self.damage.append(f"{kind} at byte {at} has a wrong length or kind")
                at = following
                continue
            if length > MAX_CHUNK_BYTES:
                self.damage.append(
                    f"{_KINDS.get(opcode, 'a record')} at byte {at} is larger than {MAX_CHUNK_BYTES >> 20} MiB"
                )
                at, crc = after, None
                continue
            if at in self.passed_over:
                at, crc = after, None
                continue
            content = self.stream.read(length)
            if opcode in _ENDS and following is None and length == _ENDS[opcode]:
                if opcode == Opcode.DATA_END:
                    self._check_data(int.from_bytes(content, "little"), crc)
                return
            if opcode not in _ENDS:
                yield opcode, content, at
            crc = None if crc is None else zlib.crc32(content, zlib.crc32(prefix, crc))
            at = after

    def _take(self, opcode: int, content: bytes) -> None:
        """One record into what is found. Raises one of DAMAGE_ERRORS where it is damaged."""
        stream = ReadDataStream(BytesIO(content))
        if opcode == Opcode.CHUNK:
            chunk = Chunk.read(stream)
            data = unpacked_chunk(chunk)
            self.unpacked += len(data)
            if self.unpacked > max(MAX_CHUNK_BYTES, MAX_UNPACKING_RATIO * self.size):
                raise Refused(
                    self.path,
                    f"unpacks to more than {MAX_UNPACKING_RATIO} times its size",
                    "is it what the controller wrote?",
                )
            for record in records_in(data):
                self._enter(record, chunk.uncompressed_crc != 0)
        elif opcode == Opcode.SCHEMA:
            self._enter(Schema.read(stream), False)
        elif opcode == Opcode.CHANNEL:
            self._enter(Channel.read(stream), False)
        elif opcode == Opcode.MESSAGE:
            self._enter(Message.read(stream, len(content)), False)
        elif opcode == Opcode.ATTACHMENT:
            attachment = Attachment.read(stream)
            crc = int.from_bytes(content[-4:], "little")
            if crc and zlib.crc32(content[:-4]) != crc:
                raise ValueError(f"({attachment.name}) fails its checksum")
            self.attached[attachment.name] = bytes(attachment.data)
        elif opcode == Opcode.METADATA:
            metadata = Metadata.read(stream)
            text = metadata.metadata.get("json")
            if text is not None:
                if metadata.metadata.get("crc32", _checksum(metadata.name, text)) != _checksum(metadata.name, text):
                    raise ValueError(f"({metadata.name}) fails its checksum")
                self.metadata[metadata.name] = json.loads(text)

    def _enter(self, record: McapRecord, checksummed: bool) -> None:
        """A schema, channel or message; `checksummed` where a checksum of its own covers it."""
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record
        elif isinstance(record, Message):
            channel = self.channels.get(record.channel_id)
            if channel is None:
                self.nameless += 1
                return
            topic = self.topics.get(_name(channel))
            if topic is None:
                topic = self.topics[_name(channel)] = self._topic(channel)
            if topic.schema.endswith(self.kind):
                self.has_unchecked |= not checksummed
                topic.messages.append(record.data)

    def _topic(self, channel: Channel) -> Topic:
        schema = self.schemas.get(channel.schema_id)
        return Topic(schema.name if schema else "", channel.message_encoding)

    def _check_data(self, expected: int, computed: int | None) -> None:
        if expected and computed is not None and expected != computed and self.has_unchecked:
            raise Refused(
                self.path,
                "the checksum over all data fails, and messages in it have none of their own",
                "copy it again",
            )

    def _written(self) -> dict[str, int]:
        """Number of messages written by topic, from our metadata or the file's statistics."""
        known = {_name(channel) for channel in self.channels.values()}
        statistics = self.summary.statistics if self.summary else None
        counts = statistics.channel_message_counts if statistics else {}
        written: Counter[str] = Counter()
        for i in set(counts) & set(self.channels):
            written[_name(self.channels[i])] += counts[i]
        stated = self.metadata.get(ROW_COUNTS_NAME)
        rows = stated if isinstance(stated, dict) and all(isinstance(n, int) for n in stated.values()) else written
        return {name: n for name, n in rows.items() if name in known}


def _name(channel: Channel) -> str:
    return channel.topic.lstrip("/")


def _checksum(name: str, text: str) -> str:
    return f"{zlib.crc32(f'{name}={text}'.encode()):08x}"


def _why(error: BaseException) -> str:
    """Words about the file; a library's own are about its code."""
    return str(error) if isinstance(error, ValueError) and type(error) is ValueError else "cannot be unpacked"
