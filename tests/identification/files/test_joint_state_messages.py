"""Messages that are no JointState are refused for what is wrong with them, in JSON as in CDR."""

import json
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer

from identification.files import joint_state
from identification.files.joint_state_cdr import decode_cdr
from xneck_foundation.errors import Refused

SAMPLE: dict[str, Any] = {
    "header": {"stamp": {"sec": 5, "nanosec": 250_000_000}, "frame_id": "base"},
    "name": ["m1", "m2"],
    "position": [0.5, -1],
    "velocity": [],
    "effort": [2.5, 3],
}


def saved(path: Path, encoding: str, *messages: bytes, **topics: list[bytes]) -> Path:
    """A file with these messages on one channel, and with those of others."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", joint_state.DEFINITION.encode())
        for topic, its_messages in {"joints": list(messages), **topics}.items():
            channel = writer.register_channel(f"/{topic}", encoding, schema)
            for k, message in enumerate(its_messages):
                writer.add_message(channel, k, message, k)
        writer.finish()
    return path


def cdr(names: list[str], blocks: list[list[float]], nanosec: int = 5, order: str = "<", sec: int = 7) -> bytes:
    """One message, written down number by number as the standard says, in either order of bytes."""
    body = struct.pack(f"{order}iI", sec, nanosec) + struct.pack(f"{order}I", 1) + b"\0"

    def count(n: int) -> bytes:
        return bytes(-len(body) % 4) + struct.pack(f"{order}I", n)

    body += count(len(names))
    for name in names:
        body += count(len(name.encode()) + 1)
        body += name.encode() + b"\0"
    for values in blocks:
        body += count(len(values))
        if values:
            body += bytes(-len(body) % 8)
            body += struct.pack(f"{order}{len(values)}d", *values)
    return (b"\0\1\0\0" if order == "<" else b"\0\0\0\0") + body


def changed(**fields: Any) -> bytes:
    """The sample with other fields; None leaves one out."""
    return json.dumps({key: value for key, value in (SAMPLE | fields).items() if value is not None}).encode()


def stamped(**stamp: Any) -> bytes:
    return changed(header={"stamp": stamp})


def raw(old: str, new: str) -> bytes:
    text = json.dumps(SAMPLE)
    assert old in text
    return text.replace(old, new).encode()


BROKEN_JSON: dict[str, tuple[bytes, str]] = {
    "fewer positions": (changed(position=[0.5]), "1 values of position for 2 names"),
    "more efforts": (changed(effort=[1, 2, 3]), "3 values of effort for 2 names"),
    "fewer velocities": (changed(velocity=[1]), "1 values of velocity for 2 names"),
    "no positions": (changed(position=[]), "holds no positions, only effort"),
    "no position": (changed(position=None), "no positions"),
    "null effort": (raw("[2.5, 3]", "null"), "effort is null, expected a list"),
    "null position": (raw("0.5", "null"), r"position\[0\] is null, expected a number"),
    "a text": (changed(position=["0.5", 1]), r"position\[0\] is the text '0.5', expected a number"),
    "true": (changed(position=[0.5, True]), r"position\[1\] is true or false, expected a number"),
    "nested": (changed(position=[[0.5, 1], [1, 2]]), r"position\[0\] is a list, expected a number"),
    "a number for a list": (changed(position=3), "position is a number, expected a list"),
    "nan": (raw("0.5", "NaN"), "NaN is no number in JSON"),
    "infinity": (raw("0.5", "-Infinity"), "-Infinity is no number in JSON"),
    "out of range": (raw("0.5", "1e999"), r"position\[0\] is too large"),
    "huge": (raw("0.5", "1" + "0" * 5000), r"position\[0\] is too large"),
    "no header": (changed(header=None), "has no header"),
    "no stamp": (changed(header={}), "header has no stamp"),
    "a stamp of text": (changed(header={"stamp": "5.25"}), "stamp is the text '5.25', expected an object"),
    "no seconds": (stamped(nanosec=5), "header.stamp has no sec"),
    "no nanoseconds": (stamped(sec=5), "header.stamp has no nanosec"),
    "null seconds": (raw('"sec": 5', '"sec": null'), "header.stamp.sec is null"),
    "half seconds": (stamped(sec=5.5, nanosec=0), "header.stamp.sec is 5.5, expected a whole number"),
    "seconds of another clock": (stamped(sec=1_700_000_000_000, nanosec=0), "header.stamp.sec is 1700000000000"),
    "huge seconds": (raw('"sec": 5', '"sec": 1' + "0" * 5000), "header.stamp.sec is too large"),
    "nanoseconds over a second": (stamped(sec=1, nanosec=10**9), "nanosec is 1000000000, expected 0 to 999999999"),
    "negative nanoseconds": (stamped(sec=1, nanosec=-1), "nanosec is -1"),
    "no names": (changed(name=None), "has no name"),
    "no joints": (changed(name=[], position=[], effort=[]), "no joint is named"),
    "a name for names": (changed(name="m1"), "name is the text 'm1', expected a list"),
    "a number for a name": (changed(name=["m1", 2]), r"name\[1\] is a number, expected a text"),
    "null for a name": (changed(name=["m1", None]), r"name\[1\] is null, expected a text"),
    "an empty name": (changed(name=["m1", ""]), r"name\[1\] is an empty text"),
    "a name twice": (changed(name=["m1", "m1"]), "2 joints are called m1"),
    "other names": (changed(name=["m1", "m3"]), "names change on the way, from m1, m2 to m1, m3"),
    "a list": (b"[1, 2]", "is a list, expected an object"),
    "a number": (b"5", "is a number, expected an object"),
    "no text": (b"\xff\xfe{}", "is not UTF-8 text"),
    "nothing": (b"", "is not JSON"),
    "half of it": (changed()[:40], "is not JSON"),
    "a key twice": (raw('"velocity": []', '"position": [1, 2]'), "key 'position' stands twice"),
    "deep": (b"[" * 100_000, "is nested too deep"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN_JSON)
def test_json_that_is_no_joint_state_is_refused_for_what_is_wrong(case: str, tmp_path: Path) -> None:
    message, reason = BROKEN_JSON[case]
    file = saved(tmp_path / "log.mcap", "json", changed(), message)
    with pytest.raises(Refused, match=rf"log\.mcap: topic /joints: .*\(message 2: .*{reason}"):
        joint_state.read(file)


def test_json_is_read_as_cdr_is(tmp_path: Path) -> None:
    """Whatever is left empty or out, and a bridge's name for nanoseconds."""
    other = changed(header={"stamp": {"sec": 6, "nsec": 1}}, velocity=None, effort=[])
    log = joint_state.read(saved(tmp_path / "a.mcap", "json", changed(), other)).logs["joints"]
    messages = [
        cdr(["m1", "m2"], [[0.5, -1.0], [], [2.5, 3.0]], nanosec=250_000_000, sec=5),
        cdr(["m1", "m2"], [[0.5, -1.0], [], []], nanosec=1, sec=6),
    ]
    same = joint_state.read(saved(tmp_path / "b.mcap", "cdr", *messages)).logs["joints"]
    assert log.names == same.names == ("m1", "m2")
    for of in ("time", "position", "effort"):
        np.testing.assert_array_equal(getattr(log, of), getattr(same, of))
    assert log.effort is not None
    np.testing.assert_array_equal(log.effort, [[2.5, 3.0], [np.nan, np.nan]])


BROKEN_CDR: dict[str, tuple[bytes, str]] = {
    "a name twice": (cdr(["m1", "m1"], [[1, 2], [], []]), "2 joints are called m1"),
    "an empty name": (cdr(["m1", ""], [[1, 2], [], []]), r"name\[1\] is an empty text"),
    "other names": (cdr(["m1", "m3"], [[1, 2], [], []]), "names change on the way"),
    "no joints": (cdr([], [[], [], []]), "no joint is named"),
    "no positions": (cdr(["m1", "m2"], [[], [1, 2], []]), "no positions"),
    "fewer positions": (cdr(["m1", "m2"], [[1], [], []]), "1 values of position for 2 names"),
    "nanoseconds over a second": (cdr(["m1", "m2"], [[1, 2], [], []], nanosec=10**9), "nanosec is 1000000000"),
    "half of it": (cdr(["m1", "m2"], [[1, 2], [], []])[:30], "message's end|ends before"),
    "nothing": (b"", "begins with"),
    "another CDR": (b"\0\7" + cdr(["m1", "m2"], [[1, 2], [], []])[2:], "begins with 0007, plain CDR with"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN_CDR)
def test_cdr_that_is_no_joint_state_is_refused_for_what_is_wrong(case: str, tmp_path: Path) -> None:
    message, reason = BROKEN_CDR[case]
    file = saved(tmp_path / "log.mcap", "cdr", cdr(["m1", "m2"], [[3, 4], [], []]), message)
    with pytest.raises(Refused, match=rf"log\.mcap: topic /joints: .*({reason})"):
        joint_state.read(file)


@pytest.mark.parametrize(
    ("others", "why"),
    [
        ([cdr(["m1", "m2"], [[], [], [1, 2]])] * 5000, "message 1: holds no positions, only effort"),
        ([cdr(["g"], [[1], [], []]), cdr(["h"], [[1], [], []])], "names change on the way, from g to h"),
        ([cdr(["g"], [[1], [], []]), b"no message"], "message 2: begins with"),
    ],
    ids=["commands", "a gripper", "damage"],
)
def test_a_topic_that_cannot_be_read_hides_no_other(others: list[bytes], why: str, tmp_path: Path) -> None:
    mine = [cdr(["m1", "m2"], [[0.5, -1.0], [], [2.5, 3.0]], sec=k) for k in range(5)]
    file = joint_state.read(saved(tmp_path / "log.mcap", "cdr", *mine, others=others))
    assert list(file.logs) == ["joints"]
    assert (len(file.logs["joints"].time), file.lost) == (5, "")
    assert why in file.faults["others"]
    with pytest.raises(Refused, match=f"topic /others: cannot be read .*{why}"):
        file.refuse_faulty("log.mcap", "joints", "others")
    file.refuse_faulty("log.mcap", "joints")


def test_another_encoding_is_named(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="encoded as 'ros1', expected cdr or json"):
        joint_state.read(saved(tmp_path / "log.mcap", "ros1", cdr(["m1"], [[1], [], []])))


@pytest.mark.parametrize("mixed", [False, True])
def test_either_order_of_bytes_is_read(mixed: bool, tmp_path: Path) -> None:
    names, rng = ["j", "joint_2", "m3"], np.random.default_rng(3)
    values = rng.normal(size=(6, 3, 3))
    messages = [
        cdr(names, [p.tolist(), v.tolist(), e.tolist()], nanosec=k, order="<" if mixed and k % 2 else ">", sec=-k)
        for k, (p, v, e) in enumerate(values)
    ]
    log = joint_state.read(saved(tmp_path / "big.mcap", "cdr", *messages)).logs["joints"]
    assert log.names == tuple(names)
    assert log.effort is not None
    np.testing.assert_array_equal(log.position, values[:, 0])
    np.testing.assert_array_equal(log.effort, values[:, 2])
    np.testing.assert_allclose(log.time, [-k + 1e-9 * k for k in range(6)])
    assert log.position.dtype.byteorder in ("=", "<" if sys.byteorder == "little" else ">")


def test_efforts_that_come_and_go_stay_efforts() -> None:
    """A message with velocity may have the size of one with effort, as some pad the end: one is not taken for the other."""
    one = cdr(["m1"], [[1.0], [5.0], []])
    other = cdr(["m1"], [[1.0], [], [7.0]]) + bytes(4)
    assert len(one) == len(other)
    log = decode_cdr([one, other], 0)
    assert log.effort is not None
    np.testing.assert_array_equal(log.effort, [[np.nan], [7.0]])


@pytest.mark.parametrize(
    ("encoding", "message"), [("json", changed()), ("cdr", cdr(["m1", "m2"], [[1, 2], [], []]))], ids=["json", "cdr"]
)
def test_the_message_is_counted_from_the_first(encoding: str, message: bytes, tmp_path: Path) -> None:
    """Messages are handed on in blocks: the count goes on."""
    file = saved(tmp_path / "log.mcap", encoding, *[message] * 5000, message[:20])
    with pytest.raises(Refused, match="message 5001: "):
        joint_state.read(file)


@pytest.mark.parametrize("encoding", ["cdr", "json"])
def test_joints_in_another_order_are_read_by_their_names(encoding: str, tmp_path: Path) -> None:
    if encoding == "json":
        messages = [changed(), changed(name=["m2", "m1"], position=[7.0, 8.0], effort=[9.0, 10.0])]
    else:
        messages = [cdr(["m1", "m2"], [[0.5, -1.0], [], [2.5, 3.0]]), cdr(["m2", "m1"], [[7, 8], [], [9, 10]])]
    log = joint_state.read(saved(tmp_path / "a.mcap", encoding, *messages)).logs["joints"]
    assert log.names == ("m1", "m2")
    assert log.effort is not None
    np.testing.assert_array_equal(log.position, [[0.5, -1.0], [8.0, 7.0]])
    np.testing.assert_array_equal(log.effort[1], [10.0, 9.0])
