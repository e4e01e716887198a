"""sensor_msgs/JointState in ROS 2 CDR, as MCAP: the one format that ROS tools and plotting tools read as named curves.

Messages of a channel all have one size, so they are written as rows of one byte table and read back as one. Metadata and
attachments come first in the file and the channels' messages interleave, so that a file that is cut off is a shorter recording.
"""

import json
import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import Writer
from numpy.typing import NDArray

from identification.dataset.series import Series
from identification.files.mcap_losses import loss_description
from identification.files.mcap_records import (
    DAMAGE_ERRORS,
    MAX_HELD_MESSAGES,
    ROW_COUNTS_NAME,
    Topic,
    checksummed,
    read_records,
)
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import warn_recovered
from xneck_foundation.version import VERSION
from xneck_foundation.whole_file import whole_file

Array = NDArray[np.float64]

DEFINITION = """\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""

CHUNK_BYTES = 1 << 18
"""bytes of rows that share a checksum and are lost together, a seventh of a second of a data set"""


@dataclass(frozen=True)
class JointStateChannel:
    """A JointState channel: time (T,), s; position and effort of shape (T, joints), NaN where not given, None where never."""

    names: tuple[str, ...]
    time: Array
    position: Array
    effort: Array | None


@dataclass(frozen=True)
class JointStateFile:
    """Contents of a file: channels by topic (without slash), JSON metadata, attachments; of a damaged file what can be read."""

    logs: dict[str, JointStateChannel]
    metadata: dict[str, Any]
    attached: dict[str, bytes]
    lost: str
    """what is lost, in words; empty where the file is complete"""


def write(
    path: str | Path,
    series: Mapping[str, Series],
    metadata: Mapping[str, Any],
    attachments: Mapping[str, bytes] | None = None,
    log_times: Mapping[str, Array] | None = None,
) -> None:
    """Series as JointState channels `/name` whose positions are the columns, with JSON metadata and attached files.

    log_times: times on the file's clock, (T,), s, of the rows of series that are stamped by another clock. Viewers align
    channels by them; `read` takes the stamps.
    """
    with whole_file(path) as part, part.open("wb") as stream:
        writer = Writer(stream, chunk_size=CHUNK_BYTES)
        writer.start(profile="ros2", library=f"xneck {VERSION}")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", DEFINITION.encode())
        for name, value in {ROW_COUNTS_NAME: {topic: len(one) for topic, one in series.items()}, **metadata}.items():
            writer.add_metadata(name, checksummed(name, value))
        for name, content in (attachments or {}).items():
            kind = "application/yaml" if name.endswith(".yaml") else "application/octet-stream"
            writer.add_attachment(0, 0, name, kind, content)
        channels = [writer.register_channel(f"/{topic}", "cdr", schema) for topic in series]
        stamps = [nanoseconds(one.time) for one in series.values()]
        logged = [nanoseconds((log_times or {}).get(topic, one.time)) for topic, one in series.items()]
        rows = [_encoded(one, at) for one, at in zip(series.values(), stamps, strict=True)]
        for c, k in _interleaved([len(at) for at in stamps]):
            # MCAP times cannot be negative, the message's stamp can
            at, published = max(int(logged[c][k]), 0), max(int(stamps[c][k]), 0)
            writer.add_message(channels[c], at, next(rows[c]), published, k)
        writer.finish()


def read(path: str | Path) -> JointStateFile:
    """An MCAP file with JointState; where it is damaged or cut off, what can be read, with a warning `Recovered`.

    Raises Refused where the file is missing, is something else, holds no JointState, or nothing of it can be read.
    """
    path = Path(path)
    parts: dict[str, list[JointStateChannel]] = {}

    def take(name: str, topic: Topic) -> None:
        decode = _decode_json if topic.encoding == "json" else _decode_cdr
        with _joint_state(path, name):
            parts.setdefault(name, []).append(decode(topic.messages))

    records = read_records(path, "JointState", take)
    logs = {}
    for name in list(parts):
        with _joint_state(path, name):
            logs[name] = _joined(parts.pop(name))
    times = {name: logs[name].time if name in logs else np.empty(0) for name in records.topics}
    lost = loss_description(records, times)
    if not logs:
        if lost:
            raise Refused(path, f"not one row of it can be read: {lost}", "copy it again, or record it again")
        only = f"topics {', '.join(records.others)}" if records.others else "no messages"
        raise Refused(path, f"holds no sensor_msgs/JointState, only {only}")
    if lost:
        warn_recovered(path, lost)
    return JointStateFile(logs, records.metadata, records.attached, lost)


@contextmanager
def _joint_state(path: Path, name: str) -> Iterator[None]:
    """Raises Refused where a topic's messages are something else."""
    try:
        yield
    except (*DAMAGE_ERRORS, LookupError, TypeError) as error:
        raise Refused(path, f"topic /{name}: messages are not JointState ({error})") from error


def as_series(log: JointStateChannel) -> Series:
    """A channel that `write` wrote, as the columns it was written from."""
    return Series(log.time, {name: log.position[:, i] for i, name in enumerate(log.names)})


def nanoseconds(time: Array) -> NDArray[np.int64]:
    """Seconds as integer nanoseconds."""
    return np.rint(np.asarray(time) * 1e9).astype(np.int64)


def _interleaved(counts: list[int]) -> Iterator[tuple[int, int]]:
    """Channel and row of all messages, channels with `counts` rows interleaved so that all are equally far along."""
    share = np.concatenate([(np.arange(n) + 0.5) / max(n, 1) for n in counts])
    channel = np.repeat(np.arange(len(counts)), counts)
    row = np.concatenate([np.arange(n) for n in counts])
    order = np.argsort(share, kind="stable")
    yield from zip(channel[order].tolist(), row[order].tolist(), strict=True)


def _encoded(series: Series, stamps: NDArray[np.int64]) -> Iterator[bytes]:
    """One CDR message after the other, encoded in blocks of rows."""
    for begin in range(0, len(stamps), MAX_HELD_MESSAGES):
        part = slice(begin, begin + MAX_HELD_MESSAGES)
        values = np.stack([column[part] for column in series.columns.values()], axis=1)
        yield from map(bytes, _encode(list(series.columns), stamps[part], values))


def _encode(names: list[str], stamps: NDArray[np.int64], positions: Array) -> NDArray[np.uint8]:
    """One CDR message a row, (T, bytes): a template of bytes into which stamps and positions are written."""
    body = bytearray(b"\x00\x01\x00\x00" + bytes(8) + struct.pack("<I", 1) + b"\x00")  # header: stamp, empty frame_id

    def pad(to: int) -> None:
        body.extend(bytes(-(len(body) - 4) % to))

    pad(4)
    body += struct.pack("<I", len(names))
    for name in names:
        pad(4)
        raw = name.encode() + b"\x00"
        body += struct.pack("<I", len(raw)) + raw
    pad(4)
    body += struct.pack("<I", len(names))
    pad(8)
    at = len(body)
    body += bytes(8 * len(names)) + struct.pack("<II", 0, 0)  # no velocity, no effort
    table = np.tile(np.frombuffer(bytes(body), dtype=np.uint8), (len(stamps), 1))
    seconds, rest = np.divmod(stamps, 1_000_000_000)
    table[:, 4:8] = seconds.astype("<i4")[:, None].view(np.uint8)
    table[:, 8:12] = rest.astype("<u4")[:, None].view(np.uint8)
    table[:, at : at + 8 * len(names)] = np.ascontiguousarray(positions, dtype="<f8").view(np.uint8)
    return table


def _decode_cdr(messages: list[bytes]) -> JointStateChannel:
    """Messages of one channel; where all have one size and the same names they are read as one table."""
    first = _layout(messages[0])
    size = len(messages[0])
    head = messages[0][12 : first.position]
    if all(len(m) == size and m[12 : first.position] == head for m in messages):
        table = np.frombuffer(b"".join(messages), dtype=np.uint8).reshape(len(messages), size)
        count = len(first.names)

        def column(at: int, kind: str, width: int, n: int) -> Any:
            return np.ascontiguousarray(table[:, at : at + width * n]).view(kind)

        def block(at: int) -> Array:
            return column(at, "<f8", 8, count).astype(float, copy=False)

        stamps = column(4, "<i4", 4, 1)[:, 0].astype(np.int64) * 1_000_000_000 + column(8, "<u4", 4, 1)[:, 0]
        effort = None if first.effort is None else block(first.effort)
        return JointStateChannel(first.names, stamps / 1e9, block(first.position), effort)
    return _joined([_decode_cdr([m]) for m in messages])


def _joined(parts: list[JointStateChannel]) -> JointStateChannel:
    """Parts of one channel that follow each other, as one."""
    if len({part.names for part in parts}) != 1:
        raise ValueError("the joints' names change on the way")
    time, position = (np.concatenate([getattr(part, of) for part in parts]) for of in ("time", "position"))
    effort = None
    if any(part.effort is not None for part in parts):
        effort = np.concatenate([np.full_like(p.position, np.nan) if p.effort is None else p.effort for p in parts])
    return JointStateChannel(parts[0].names, time, position, effort)


@dataclass(frozen=True)
class _Layout:
    names: tuple[str, ...]
    position: int
    effort: int | None


def _layout(data: bytes) -> _Layout:
    """Places of the numbers in a message."""
    if data[:2] != b"\x00\x01":
        raise ValueError("not little-endian CDR")
    at = 12

    def number() -> int:
        nonlocal at
        at += -(at - 4) % 4
        at += 4
        return struct.unpack_from("<I", data, at - 4)[0]

    def text() -> str:
        nonlocal at
        length = number()
        raw = data[at : at + length]
        if len(raw) != length:
            raise ValueError("a text runs past the message's end")
        at += length
        return raw.rstrip(b"\x00").decode()

    def numbers() -> tuple[int, int]:
        nonlocal at
        count = number()
        if count:
            at += -(at - 4) % 8
        begin = at
        at += 8 * count
        if at > len(data):
            raise ValueError("numbers run past the message's end")
        return count, begin

    text()
    names = tuple(text() for _ in range(number()))
    blocks = [numbers() for _ in range(3)]
    for word, (count, _) in zip(("position", "velocity", "effort"), blocks, strict=True):
        if count not in (0, len(names)):
            raise ValueError(f"{count} values of {word} for {len(names)} names")
    position, _, effort = [begin if count else None for count, begin in blocks]
    if position is None:
        raise ValueError("no positions")
    return _Layout(names, position, effort)


def _decode_json(messages: list[bytes]) -> JointStateChannel:
    rows = [json.loads(m) for m in messages]
    names = tuple(rows[0]["name"])
    if any(tuple(r["name"]) != names for r in rows):
        raise ValueError("the joints' names change on the way")

    def stamp(row: dict[str, Any]) -> float:
        at = row["header"]["stamp"]
        return at["sec"] + at.get("nanosec", at.get("nsec", 0)) / 1e9

    def block(word: str) -> Array:
        return np.array([r.get(word) or [np.nan] * len(names) for r in rows], dtype=float)

    effort = block("effort") if any(r.get("effort") for r in rows) else None
    return JointStateChannel(names, np.array([stamp(r) for r in rows]), block("position"), effort)
