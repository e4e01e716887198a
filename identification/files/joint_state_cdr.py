"""sensor_msgs/JointState in ROS 2 CDR: written as rows of one byte table, and read back as one where all have one layout."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from identification.files.joint_state_channel import (
    NANOSECONDS,
    JointStateChannel,
    check_lengths,
    check_names,
    joined,
)

Array = NDArray[np.float64]

_BYTE_ORDERS = {b"\x00\x00": ">", b"\x00\x01": "<"}
"""by the two bytes that a message in plain CDR begins with"""
_STAMP_END = 12
"""byte after representation (4) and stamp (8)"""


class CdrTable:
    """A series as CDR messages, each a row of `size` bytes: a template into which stamps and positions are written."""

    def __init__(self, series: Series, stamps: NDArray[np.int64]) -> None:
        """stamps: (T,), ns"""
        self._columns, self._stamps = list(series.columns.values()), stamps
        body = bytearray(
            b"\x00\x01\x00\x00" + bytes(8) + struct.pack("<I", 1) + b"\x00"
        )  # header: stamp, empty frame_id

        def pad(to: int) -> None:
            body.extend(bytes(-(len(body) - 4) % to))

        pad(4)
        count = len(self._columns)
        body += struct.pack("<I", count)
        for name in series.columns:
            pad(4)
            raw = name.encode() + b"\x00"
            body += struct.pack("<I", len(raw)) + raw
        pad(4)
        body += struct.pack("<I", count)
        pad(8)
        self._positions = slice(len(body), len(body) + 8 * count)
        body += bytes(8 * count) + struct.pack("<II", 0, 0)  # no velocity, no effort
        self._template = np.frombuffer(bytes(body), dtype=np.uint8)

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return len(self._template)

    def rows(self, part: slice) -> NDArray[np.uint8]:
        """Some of the messages, (rows, size)."""
        stamps = self._stamps[part]
        table = np.tile(self._template, (len(stamps), 1))
        seconds, rest = np.divmod(stamps, NANOSECONDS)
        table[:, 4:8] = seconds.astype("<i4")[:, None].view(np.uint8)
        table[:, 8:12] = rest.astype("<u4")[:, None].view(np.uint8)
        if self._columns:
            positions = np.stack([column[part] for column in self._columns], axis=1)
            table[:, self._positions] = np.ascontiguousarray(positions, dtype="<f8").view(np.uint8)
        return table


def decode_cdr(messages: Sequence[bytes], before: int) -> JointStateChannel:
    """Messages of one channel, of which `before` came earlier. Raises ValueError with the number of the message that is none."""
    first = _numbered(messages[0], before + 1)
    size = len(messages[0])
    frame = first.frame(messages[0])
    if all(len(m) == size and first.frame(m) == frame for m in messages):
        return _table(messages, first, before)
    return joined([_table([m], _numbered(m, before + k), before + k - 1) for k, m in enumerate(messages, start=1)])


def _table(messages: Sequence[bytes], layout: "_Layout", before: int) -> JointStateChannel:
    """Messages that all have one layout."""
    table = np.frombuffer(b"".join(messages), dtype=np.uint8).reshape(len(messages), -1)
    order, count = layout.order, len(layout.names)

    def column(at: int, kind: str, width: int, n: int) -> Any:
        return np.ascontiguousarray(table[:, at : at + width * n]).view(f"{order}{kind}")

    def block(at: int) -> Array:
        return column(at, "f8", 8, count).astype(float, copy=False)

    rest = column(8, "u4", 4, 1)[:, 0]
    if np.any(rest >= NANOSECONDS):
        k = int(np.argmax(rest >= NANOSECONDS))
        what = f"header.stamp.nanosec is {rest[k]}, expected 0 to {NANOSECONDS - 1}"
        raise ValueError(f"message {before + k + 1}: {what}")
    stamps = column(4, "i4", 4, 1)[:, 0].astype(np.int64) * NANOSECONDS + rest
    effort = None if layout.effort is None else block(layout.effort)
    return JointStateChannel(layout.names, stamps / NANOSECONDS, block(layout.position), effort)


@dataclass(frozen=True)
class _Layout:
    """Where a message's numbers stand, in bytes; `order` is that of the bytes of a number, as struct names it."""

    order: str
    names: tuple[str, ...]
    position: int
    velocity: int | None
    effort: int | None

    def frame(self, data: bytes) -> tuple[bytes, ...]:
        """All of a message but its stamp and its numbers: what says where they stand."""
        width = 8 * len(self.names)
        begins = [begin for begin in (self.position, self.velocity, self.effort) if begin is not None]
        ends = [_STAMP_END, *(begin + width for begin in begins)]
        return (data[:2], *(data[end:begin] for end, begin in zip(ends, [*begins, len(data)], strict=True)))


def _numbered(data: bytes, number: int) -> _Layout:
    try:
        return _layout(data)
    except ValueError as error:
        raise ValueError(f"message {number}: {error}") from error


def _layout(data: bytes) -> _Layout:
    """The layout of one message. Raises ValueError where it has none."""
    order = _BYTE_ORDERS.get(data[:2])
    if order is None:
        raise ValueError(f"begins with {data[:2].hex()}, plain CDR with 0001 or 0000")
    at = _STAMP_END

    def number() -> int:
        nonlocal at
        at += -(at - 4) % 4
        at += 4
        if at > len(data):
            raise ValueError("ends before its numbers do")
        return struct.unpack_from(f"{order}I", data, at - 4)[0]

    def text() -> str:
        nonlocal at
        length = number()
        raw = data[at : at + length]
        if len(raw) != length:
            raise ValueError("a text runs past the message's end")
        at += length
        try:
            return raw.rstrip(b"\x00").decode()
        except UnicodeDecodeError as error:
            raise ValueError("a name is not UTF-8 text") from error

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
    check_names(names)
    blocks = {word: numbers() for word in ("position", "velocity", "effort")}
    check_lengths(len(names), {word: count for word, (count, _) in blocks.items()})
    position, velocity, effort = [begin if count else None for count, begin in blocks.values()]
    assert position is not None  # by check_lengths
    return _Layout(order, names, position, velocity, effort)
