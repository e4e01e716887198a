"""sensor_msgs/JointState in ROS 2 CDR, as MCAP: the one format that ROS tools and plotting tools read as named curves.

Messages of a channel all have one size, so they are written as rows of one byte table and read back as one. Metadata and
attachments come first in the file and the channels' messages interleave, so that a file that is cut off is a shorter recording.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Schema
from numpy.typing import NDArray

from identification.dataset.series import Series
from identification.files.joint_state_cdr import CdrTable, decode_cdr
from identification.files.joint_state_channel import JointStateChannel, joined
from identification.files.joint_state_json import decode_json
from identification.files.mcap_losses import loss_description
from identification.files.mcap_records import (
    ROW_COUNTS_NAME,
    Topic,
    checksummed,
    read_records,
)
from identification.files.mcap_tables import FileHead, MessageTable, write_tables
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed
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

DECODERS = {"cdr": decode_cdr, "json": decode_json}
"""by the encoding that a file names"""


@dataclass(frozen=True)
class JointStateFile:
    """Contents of a file: channels by topic (without slash), JSON metadata, attachments; of a damaged file what can be read."""

    logs: dict[str, JointStateChannel]
    metadata: dict[str, Any]
    attached: dict[str, bytes]
    lost: str
    """what is lost, in words; empty where the file is complete"""
    faults: dict[str, str] = field(default_factory=dict)
    """what is wrong with the messages of each topic that cannot be read: others are read all the same"""

    def refuse_faulty(self, path: str | Path, *topics: str) -> None:
        """Raises Refused where one of these topics cannot be read."""
        for topic in topics:
            if topic in self.faults:
                raise Refused(path, *unreadable_topic(topic, self.faults[topic]))


def unreadable_topic(topic: str, fault: str) -> tuple[str, str]:
    """What to say where a topic is needed whose messages cannot be read."""
    return (
        f"topic /{topic}: cannot be read ({fault})",
        "all its messages must be JointState, of the same joints, with a position of each",
    )


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
    stated = {ROW_COUNTS_NAME: {topic: len(one) for topic, one in series.items()}, **metadata}
    head = FileHead(
        profile="ros2",
        library=f"xneck {VERSION}",
        schema=Schema(id=1, name="sensor_msgs/msg/JointState", encoding="ros2msg", data=DEFINITION.encode()),
        encoding="cdr",
        metadata={name: checksummed(name, value) for name, value in stated.items()},
        attachments={name: (_media_type(name), content) for name, content in (attachments or {}).items()},
    )
    tables = [_table(topic, one, (log_times or {}).get(topic, one.time)) for topic, one in series.items()]
    with whole_file(path) as part, part.open("wb") as stream:
        write_tables(stream, head, tables)


def _media_type(name: str) -> str:
    return "application/yaml" if name.endswith(".yaml") else "application/octet-stream"


def _table(topic: str, series: Series, log_time: Array) -> MessageTable:
    stamps = nanoseconds(series.time)
    messages = CdrTable(series, stamps)
    # MCAP times cannot be negative, the message's stamp can
    published = stamps if not len(stamps) or stamps.min() >= 0 else np.maximum(stamps, 0)
    logged = published if log_time is series.time else np.maximum(nanoseconds(log_time), 0)
    return MessageTable(f"/{topic}", logged, published, messages.size, messages.rows)


def read(path: str | Path, within: tuple[float, float] | None = None) -> JointStateFile:
    """An MCAP file with JointState; where it is damaged or cut off, what can be read, with a warning `Recovered`.

    within: first and last log time, s. Of a file with an index only the chunks are read that hold something between, so that rows
    beyond are among what is returned, but no more than a chunk's on either side.
    Raises Refused where the file is missing, is something else, holds no JointState, or nothing of it can be read. A topic whose
    messages cannot be read is among `faults`, where there are others: whoever needs it refuses it.
    """
    path = Path(path)
    parts: dict[str, list[JointStateChannel]] = {}
    faults: dict[str, str] = {}

    def take(name: str, topic: Topic) -> None:
        if name in faults:
            return
        before = sum(len(part.time) for part in parts.get(name, ()))
        try:
            if topic.encoding not in DECODERS:
                raise ValueError(f"its messages are encoded as {topic.encoding!r}, expected cdr or json")
            parts.setdefault(name, []).append(DECODERS[topic.encoding](topic.messages, before))
        except (ValueError, MemoryError) as error:
            faults[name] = str(error)
            parts.pop(name, None)

    between = None if within is None else (int(within[0] * 1e9), int(within[1] * 1e9) + 1)
    records = read_records(path, "JointState", take, between)
    logs = {}
    for name in list(parts):
        try:
            logs[name] = joined(parts.pop(name))
        except (ValueError, MemoryError) as error:
            faults[name] = str(error)
    readable = {name: topic for name, topic in records.topics.items() if name not in faults}
    times = {name: logs[name].time if name in logs else np.empty(0) for name in readable}
    lost = loss_description(replace(records, topics=readable), times)
    file = JointStateFile(logs, records.metadata, records.attached, lost, faults)
    if not logs:
        file.refuse_faulty(path, *faults)
        if lost:
            raise Refused(path, f"not one row of it can be read: {lost}", "copy it again, or record it again")
        only = f"topics {listed(records.others)}" if records.others else "no messages"
        raise Refused(path, f"holds no sensor_msgs/JointState, only {only}")
    if lost:
        warn_recovered(path, lost)
    return file


def as_series(log: JointStateChannel) -> Series:
    """A channel that `write` wrote, as the columns it was written from."""
    return Series(log.time, {name: log.position[:, i] for i, name in enumerate(log.names)})


def nanoseconds(time: Array) -> NDArray[np.int64]:
    """Seconds as integer nanoseconds."""
    return np.rint(np.asarray(time) * 1e9).astype(np.int64)
