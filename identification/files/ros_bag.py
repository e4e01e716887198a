"""JointState in ROS bags of both kinds, .bag and .db3, through rosbags, which the extra `bags` brings."""

import sqlite3
import struct
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from identification.files.joint_state import JointStateFile
from identification.files.joint_state_cdr import decode_cdr
from identification.files.joint_state_channel import (
    NANOSECONDS,
    JointStateChannel,
    check_lengths,
    check_names,
    order_of,
)
from xneck_foundation.errors import Refused
from xneck_foundation.extras import needs_extra
from xneck_foundation.input_file import check_input
from xneck_foundation.one_line import listed

SUFFIXES = (".bag", ".db3")
_JOINT_STATE = "sensor_msgs/msg/JointState"
"""as rosbags calls it in bags of both kinds"""


def read_bag(path: Path) -> JointStateFile:
    """The JointState topics of a bag. Of ROS 2 name the .db3, with its metadata.yaml beside it.

    Raises Refused where rosbags is missing, the bag is damaged, has several files, or holds no JointState that can be read.
    """
    check_input(path)
    with needs_extra("bags", "rosbags", path):
        import rosbags.rosbag1
        import rosbags.rosbag2
        from rosbags.serde import SerdeError
    if path.suffix.lower() == ".db3":
        _check_folder(path)
    errors = (rosbags.rosbag1.ReaderError, rosbags.rosbag2.ReaderError, SerdeError)
    messages: dict[str, list[bytes]] = {}
    others: set[str] = set()
    with _readable(path, errors):
        bag = rosbags.rosbag1.Reader(path) if path.suffix.lower() == ".bag" else rosbags.rosbag2.Reader(path.parent)
        with bag:
            wanted = [c for c in bag.connections if c.msgtype == _JOINT_STATE]
            others |= {c.topic for c in bag.connections} - {c.topic for c in wanted}
            for connection, _, data in bag.messages(connections=wanted) if wanted else ():
                messages.setdefault(connection.topic.removeprefix("/"), []).append(bytes(data))
    if not messages:
        only = f"topics {listed(sorted(others))}" if others else "no messages"
        raise Refused(path, f"holds no sensor_msgs/JointState, only {only}")
    file = JointStateFile(logs={}, metadata={}, attached={}, lost="")
    for topic, raws in messages.items():
        try:
            file.logs[topic] = _decode_ros1(raws) if path.suffix.lower() == ".bag" else decode_cdr(raws, 0)
        except (ValueError, SerdeError) as error:
            file.faults[topic] = str(error)
    if not file.logs:
        file.refuse_faulty(path, *file.faults)
    return file


def _decode_ros1(messages: Sequence[bytes]) -> JointStateChannel:
    """Messages of one topic in ROS 1's encoding. Raises ValueError where one is none, or rosbags' own error."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    parts: list[Any] = [store.deserialize_ros1(message, _JOINT_STATE) for message in messages]
    names = tuple(parts[0].name)
    check_names(names)
    orders = [order_of(names, part.name) for part in parts]
    for part in parts:
        check_lengths(len(names), {word: len(getattr(part, word)) for word in ("position", "velocity", "effort")})
    stamps = np.array([part.header.stamp.sec * NANOSECONDS + part.header.stamp.nanosec for part in parts])
    unknown = np.full(len(names), np.nan)
    ordered = list(zip(parts, orders, strict=True))
    position = np.array([part.position[order] for part, order in ordered])
    effort = np.array([part.effort[order] if len(part.effort) else unknown for part, order in ordered])
    return JointStateChannel(names, stamps / NANOSECONDS, position, None if np.isnan(effort).all() else effort)


def _check_folder(path: Path) -> None:
    """Refused where a bag of ROS 2 is more than one file and its metadata, or one of them is a link to elsewhere."""
    folder = path.parent.resolve()
    if not (folder / "metadata.yaml").is_file():
        raise Refused(path, "has no metadata.yaml beside it", "keep the bag's folder as ROS wrote it")
    for file in (path, folder / "metadata.yaml"):
        if file.resolve().parent != folder:
            raise Refused(
                path, f"{file.name} is a link that leads out of the bag's folder", "put the file itself there"
            )
    if sum(file.suffix.lower() == ".db3" for file in folder.iterdir()) > 1:
        raise Refused(path, "is one of several files of its bag", "join them: ros2 bag convert, or give the .mcap")


@contextmanager
def _readable(path: Path, errors: tuple[type[Exception], ...]) -> Iterator[None]:
    """Refused where a bag is damaged, or something else."""
    damage = (sqlite3.Error, struct.error, ValueError, LookupError, TypeError, AssertionError, EOFError, OSError)
    try:
        yield
    except (*errors, *damage, MemoryError) as error:
        what = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise Refused(path, f"cannot be read as a ROS bag ({what})", "is it a whole file?") from error
