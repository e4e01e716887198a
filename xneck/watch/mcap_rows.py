"""The rows of a log as MCAP while it is written: whole records only; most writers collect rows to chunks of seconds."""

import struct
from io import BytesIO

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Schema

from identification.dataset.series import Series
from identification.files.joint_state import DECODERS
from identification.files.joint_state_channel import JointStateChannel
from identification.files.mcap_chunks import MAX_CHUNK_BYTES, PREFIX, records_in, unpacked_chunk
from identification.files.mcap_index import DAMAGE_ERRORS, MAGIC
from mechanism.description import Neck
from synchronisation.motor_topic import motor_channel
from xneck.watch.growing_file import GrowingFile
from xneck_foundation.errors import Refused

_BLOCK_BYTES = 1 << 22
_KIND = "JointState"


class McapRows:
    """New rows of a growing MCAP."""

    def __init__(self, source: GrowingFile, neck: Neck) -> None:
        self._source, self._neck = source, neck
        self._rest = b""
        self._begun = False
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._messages: dict[str, list[bytes]] = {}
        self._encodings: dict[str, str] = {}
        self._counts: dict[str, int] = {}
        self._topics: dict[str, JointStateChannel] = {}
        """topics so far, without rows"""
        self._faults: dict[str, str] = {}
        """what is wrong with each topic that cannot be read"""

    def new(self) -> Series | None:
        """Rows that came since the last call, as the file has them; None where none did. Raises Refused as `read_log` does."""
        data = self._rest + self._source.read_available(_BLOCK_BYTES)
        at = 0
        if not self._begun:
            if len(data) < len(MAGIC):
                self._rest = data
                return None
            if not data.startswith(MAGIC):
                raise Refused(self._source.path, "is not an MCAP file", "is it the right one?")
            self._begun, at = True, len(MAGIC)
        while len(data) >= at + PREFIX.size:
            opcode, length = PREFIX.unpack_from(data, at)
            end = at + PREFIX.size + length
            if opcode in (Opcode.DATA_END, Opcode.FOOTER) or length > MAX_CHUNK_BYTES or end > len(data):
                break
            try:
                self._take(opcode, data[at + PREFIX.size : end])
            except DAMAGE_ERRORS as error:
                raise Refused(self._source.path, f"a record is damaged ({error})", "record again") from error
            at = end
        self._rest = data[at:]
        return self._rows()

    def _take(self, opcode: int, content: bytes) -> None:
        stream = ReadDataStream(BytesIO(content))
        if opcode == Opcode.CHUNK:
            for record in records_in(unpacked_chunk(Chunk.read(stream))):
                self._enter(record)
        elif opcode == Opcode.SCHEMA:
            self._enter(Schema.read(stream))
        elif opcode == Opcode.CHANNEL:
            self._enter(Channel.read(stream))
        elif opcode == Opcode.MESSAGE:
            self._enter(Message.read(stream, len(content)))

    def _enter(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record
        elif isinstance(record, Message) and record.channel_id in self._channels:
            channel = self._channels[record.channel_id]
            schema = self._schemas.get(channel.schema_id)
            if schema is not None and schema.name.endswith(_KIND) and channel.message_encoding in DECODERS:
                name = channel.topic.lstrip("/")
                self._encodings[name] = channel.message_encoding
                self._messages.setdefault(name, []).append(record.data)

    def _rows(self) -> Series | None:
        if not self._messages:
            return None
        logs = dict(self._topics)
        for name, messages in self._messages.items():
            if name in self._faults:
                continue
            before = self._counts.get(name, 0)
            try:
                logs[name] = DECODERS[self._encodings[name]](messages, before)
            except (ValueError, MemoryError, struct.error) as error:
                self._faults[name] = str(error)
                logs.pop(name, None)
                self._topics.pop(name, None)
                continue
            self._counts[name] = before + len(messages)
            joints = len(logs[name].names)
            self._topics[name] = JointStateChannel(logs[name].names, np.empty(0), np.empty((0, joints)), None)
        self._messages.clear()
        rows = motor_channel(logs, self._neck, self._source.path, self._faults)
        return rows if len(rows) else None
