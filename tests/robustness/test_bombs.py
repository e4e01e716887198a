"""Files made to use up memory or time are refused before they do, and no path leads out of a recording's folder."""

import json
import shutil
import struct
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.writer import CompressionType, Writer

from identification.files import joint_state
from identification.files.mcap_chunks import MAX_CHUNK_BYTES
from identification.files.mcap_index import MAGIC
from synchronisation.csv_table import read_table
from tests.robustness.judge import TRIED, read
from tests.robustness.sources import H
from xneck.recording.recording_folder import read_recording
from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import load_yaml, parse_yaml

GIB = 1 << 30
RECORD = struct.Struct("<BQ")


def unpacks_to(path: Path, kind: str, data: bytes, size: int, times: int = 1) -> None:
    """An MCAP of `times` chunks that say they unpack to `size` bytes."""
    builder = RecordBuilder()
    for _ in range(times):
        Chunk(kind, data, 0, 0, 0, size).write(builder)
    path.write_bytes(MAGIC + builder.end())


def zeros(kind: str, size: int) -> bytes:
    """So many zeros, packed."""
    return zstandard.compress(bytes(size)) if kind == "zstd" else lz4.frame.compress(bytes(size))


def claims_little(path: Path) -> None:
    unpacks_to(path, "zstd", zstandard.ZstdCompressor(write_content_size=False).compress(bytes(GIB // 4)), 1000)


def claims_little_in_lz4(path: Path) -> None:
    unpacks_to(path, "lz4", zeros("lz4", GIB // 4), 1000)


def claims_an_exbibyte(path: Path) -> None:
    unpacks_to(path, "zstd", zeros("zstd", 1000), 1 << 60)


def one_byte_too_many(path: Path) -> None:
    unpacks_to(path, "zstd", zeros("zstd", MAX_CHUNK_BYTES + 1), MAX_CHUNK_BYTES + 1)


def records_of_nothing(path: Path) -> None:
    """30 million records of no bytes in 8 kB."""
    unpacks_to(path, "zstd", zeros("zstd", MAX_CHUNK_BYTES), MAX_CHUNK_BYTES)


def many_chunks(path: Path) -> None:
    """A thousand chunks of 64 MiB in 2 MB."""
    text = b"x" * (1 << 26)
    schema = (
        RECORD.pack(Opcode.SCHEMA, len(text) + 14) + struct.pack("<HI", 1, 0) + struct.pack("<II", 0, len(text)) + text
    )
    unpacks_to(path, "zstd", zstandard.compress(schema), len(schema), 1000)


def a_record_of_an_exbibyte(path: Path) -> None:
    path.write_bytes(MAGIC + RECORD.pack(Opcode.CHUNK, 1 << 60) + bytes(100))


def a_record_of_many_gibibytes(path: Path) -> None:
    """A file with a hole, which takes no room on the disk."""
    with path.open("wb") as stream:
        stream.write(MAGIC + RECORD.pack(Opcode.ATTACHMENT, 64 * GIB))
        stream.truncate(65 * GIB)


def deep_json(path: Path) -> None:
    json_messages(path, b"[" * 100_000)


def number_without_end(path: Path) -> None:
    json_messages(path, b'{"name": ["a"], "position": [1' + b"0" * 400 + b'], "header": {"stamp": {"sec": 1}}}')


def metadata_of_another_kind(path: Path) -> None:
    """Names as ours, but with contents of somebody else's."""
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE)
        writer.start()
        for name in ("rows", "clock", "angles"):
            writer.add_metadata(name, {"json": json.dumps([1, "x"])})
        writer.finish()


def json_messages(path: Path, *messages: bytes) -> None:
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("sensor_msgs/JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/joints", "json", schema)
        for k, message in enumerate(messages):
            writer.add_message(channel, k, message, k)
        writer.finish()


MCAPS: list[Callable[[Path], None]] = [
    claims_little,
    claims_little_in_lz4,
    claims_an_exbibyte,
    one_byte_too_many,
    records_of_nothing,
    many_chunks,
    a_record_of_an_exbibyte,
    a_record_of_many_gibibytes,
    deep_json,
    number_without_end,
    metadata_of_another_kind,
]


@pytest.mark.parametrize("make", MCAPS, ids=lambda make: make.__name__)
def test_mcap_bombs_are_refused(make: Callable[[Path], None], tmp_path: Path) -> None:
    """In the time and the memory that the largest chunk takes."""
    make(tmp_path / "bomb.mcap")
    assert read("bombs", tmp_path / "bomb.mcap", joint_state.read) is None


def test_what_a_robot_at_rest_logs_is_no_bomb(tmp_path: Path) -> None:
    """An hour at 500 Hz in which nothing moves but the clock is packed to no less than a tenth of what is let through."""
    path, rows = tmp_path / "rest.mcap", 60_000
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=1 << 22)
        writer.start()
        schema = writer.register_schema("sensor_msgs/JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/joints", "json", schema)
        row: dict[str, object] = {}
        for k in range(rows):
            row = {"header": {"stamp": {"sec": k // 500, "nanosec": k % 500 * 2_000_000}}, "name": ["motor1", "motor2"]}
            row |= {"position": [0.1, 0.2], "velocity": [0.0, 0.0], "effort": [12.5, 12.5]}
            writer.add_message(channel, k * 2_000_000, json.dumps(row).encode(), k * 2_000_000, k)
        writer.finish()
    found = joint_state.read(path)
    assert len(found.logs["joints"].time) == rows
    assert rows * (len(json.dumps(row)) + 31) < 20 * 10 * path.stat().st_size


YAMLS = {
    "laughs": "a: &a [x, x, x]\n" + "".join(f"{c}: &{c} [*{b}, *{b}, *{b}]\n" for b, c in pairwise("abcdefghijklmnopqrstuvw")),
    "lists in lists": "a: " + "[" * 50_000,
    "keys in keys": "{a: " * 50_000,
    "dashes": "- " * 50_000,
    "questions": "? " * 50_000,
    "a long number": "a: " + "9" * 900_000,
    "a very long text": "a: " + "x" * 5_000_000,
    "an object": "a: !!python/object/apply:os.system [true]",
    "bytes": "a: !!binary aGFsbG8=",
    "a date": "a: !!timestamp 2001-01-01",
    "a set": "a: !!set {x, y}",
    "merged": "a: {b: 1}\nc: {<<: *a}",
    "nul": "a: \0",
    "a surrogate": 'a: "\\ud800"',
    "many values": "a: [" + "1, " * 300_000 + "]",
    "many keys": "\n".join(f"k{k}: 1" for k in range(80_000)),
    "empty lists": "a: [" + "[], " * 240_000 + "]",
    "a number of many digits": "a: [" + ("9" * 4000 + ", ") * 240 + "]",
    "a long tag": "a: !" + "x" * 900_000 + " 1",
    "an anchor twice": "a: [" + "&x 1, " * 160_000 + "]",
}  # fmt: skip


@pytest.mark.parametrize("name", YAMLS)
def test_yaml_bombs_are_refused(name: str, tmp_path: Path) -> None:
    (tmp_path / "bomb.yaml").write_text(YAMLS[name])
    if name == "a surrogate":
        read("bombs", tmp_path / "bomb.yaml", read_recording)
    else:
        assert read("bombs", tmp_path / "bomb.yaml", load_yaml) is None


UNREADABLE: dict[str, bytes] = {
    "UTF-16": "xneck: 1".encode("utf-16"),
    "UTF-16 without a mark": "xneck: 1".encode("utf-16-le"),
    "Latin 1": "a: caf\xe9".encode("latin-1"),
    "2 MB": b"# " + b"x" * 2_000_000,
}


@pytest.mark.parametrize("name", UNREADABLE)
def test_what_is_no_text_is_refused(name: str, tmp_path: Path) -> None:
    (tmp_path / "bomb.yaml").write_bytes(UNREADABLE[name])
    assert read("bombs", tmp_path / "bomb.yaml", load_yaml) is None


def test_yaml_in_a_data_set_is_measured_before_it_is_parsed() -> None:
    """An attachment may be larger than any file that is read from a disk."""
    with pytest.raises(Refused, match=r"data\.mcap:neck\.yaml: larger than 1 MB"):
        parse_yaml("#\n" * 600_000, "data.mcap:neck.yaml")


@pytest.mark.parametrize("columns", ["distinct", "one twice", "one missing"])
def test_a_header_of_many_columns_is_read_in_time(columns: str, tmp_path: Path) -> None:
    """300,000 of them in less than a second: an hour where each is looked for among all."""
    header = ["time", "theta1", *(f"c{k}" for k in range(300_000))]
    header[1 if columns == "one missing" else -1] = "c7" if columns == "one twice" else "other"
    rows = "\n".join(",".join([str(k)] * len(header)) for k in range(2))
    (tmp_path / "wide.csv").write_text(",".join(header) + "\n" + rows + "\n")
    found = read("bombs", tmp_path / "wide.csv", lambda path: read_table(path, ["theta1"], ["f1"]))
    assert (found is not None) == (columns == "distinct")


def recording(folder: Path) -> Path:
    folder.mkdir()
    for name in ("angles.csv", "log.mcap", "neck.yaml", "recording.yaml"):
        shutil.copy(H / name, folder / name)
    return folder


@pytest.mark.parametrize("way", ["..", "absolute", "link", "folder link", "through itself"])
def test_a_recording_names_nothing_outside_its_folder(way: str, tmp_path: Path) -> None:
    """Neither by its path nor by a link that leads out: what a folder is sent as is what is read. Links within it are fine."""
    TRIED["paths"] += 1
    here = recording(tmp_path / "recording")
    other = tmp_path / "other"
    other.mkdir()
    shutil.move(here / "angles.csv", other / "angles.csv")
    named = {"..": "../other/angles.csv", "absolute": str(other / "angles.csv"), "link": "angles.csv"}.get(
        way, "sub/angles.csv"
    )
    if way == "link":
        (here / "angles.csv").symlink_to(other / "angles.csv")
    elif way == "folder link":
        (here / "sub").symlink_to(other)
    elif way == "through itself":
        (here / "sub").symlink_to("sub")
    (here / "recording.yaml").write_text(f"angles: {json.dumps(named)}\nlog: log.mcap\nneck: neck.yaml\n")
    with pytest.raises(Refused, match=r"recording\.yaml: angles: .*(leaves the recording's folder|does not exist)"):
        read_recording(here)


def test_links_within_a_recording_are_followed(tmp_path: Path) -> None:
    here = recording(tmp_path / "recording")
    (here / "raw").mkdir()
    shutil.move(here / "angles.csv", here / "raw/angles.csv")
    (here / "angles.csv").symlink_to("raw/angles.csv")
    assert read_recording(here).angles == here / "angles.csv"
    link = tmp_path / "link"
    link.symlink_to(here)
    assert read_recording(link).angles == link / "angles.csv"
