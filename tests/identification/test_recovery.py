"""Damaged and half-written MCAP files: what is whole is read, what is lost is named, and no number is ever another one."""

import io
import json
import struct
import warnings
from dataclasses import dataclass
from itertools import combinations_with_replacement
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from identification.dataset.dataset import DataSet
from identification.dataset.dataset_file import read_dataset, write_dataset
from identification.dataset.series import Series
from identification.files import joint_state, mcap_index
from mechanism.description import read_neck
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import Recovered, collected_recoveries

NECK = NECK_FILE
EVERYWHERE = settings(
    max_examples=150, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def series(rows: int, columns: int, seed: int, rate: float = 500.0) -> Series:
    values = np.random.default_rng(seed).normal(size=(columns, rows))
    return Series(100 + np.arange(rows) / rate, {f"c{i + 1}": v for i, v in enumerate(values)})


def data_set(seconds: float = 2.0) -> DataSet:
    """In columns as wide as those of a real one, and of the same names; numbers are noise of a tenth."""
    joints = [f"alpha{i}{suffix}" for suffix in ("", "_d", "_dd") for i in (1, 2, 3)]
    motors = [f"{stem}{j}" for stem in ("theta", "f") for j in (1, 2, 3, 4)]
    cables = [f"theta{j}{suffix}" for suffix in ("_d", "_dd") for j in (1, 2, 3, 4)] + [f"x{j}" for j in (1, 2, 3, 4)]
    rates = {
        "state": ([*joints, *motors, *cables, *(f"more{i}" for i in range(18))], 500.0),
        "fasquelle": ([*joints, *motors, *cables], 31.25),
        "log": (motors, 500.0),
        "angles": ([f"{stem}{i}" for stem in ("alpha", "sigma", "common") for i in (1, 2, 3)], 30.0),
        "covariance": ([f"cov_{a}_{b}" for a, b in combinations_with_replacement(joints, 2)], 10.0),
    }
    parts = {}
    for name, (columns, rate) in rates.items():
        made = series(max(2, int(rate * seconds)), len(columns), len(columns), rate)
        values = [0.1 * column for column in made.columns.values()]
        parts[name] = Series(
            made.time, {c: np.abs(v) if c.startswith("sigma") else v for c, v in zip(columns, values, strict=True)}
        )
    records = {"clock": {"offset_s": 1.25}, "check": {"verdict": "consistent"}, "provenance": {"xneck": "0"}}
    return DataSet(read_neck(NECK), NECK.read_text(), **parts, **records)


@dataclass(frozen=True)
class Written:
    """A file's bytes and what it was written from."""

    data: DataSet
    whole: bytes
    path: Path

    def damaged(self, content: bytes) -> tuple[DataSet | None, str]:
        """What is read of other bytes, None where they are refused; and what was said of it."""
        self.path.write_bytes(content)
        with collected_recoveries() as said:
            try:
                found = read_dataset(self.path)
            except Refused as refusal:
                return None, str(refusal)
        return found, " ".join(said)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Written:
    path = tmp_path_factory.mktemp("data") / "dataset.mcap"
    data = data_set()
    write_dataset(data, path)
    return Written(data, path.read_bytes(), path)


def rows_as_written(found: Series, true: Series) -> int:
    """How many rows there are, each of them to the last bit one that was written."""
    if not len(found):
        return 0
    at = np.searchsorted(true.time, found.time - 1e-6)
    np.testing.assert_allclose(found.time, true.time[at], atol=1e-9)
    assert list(found.columns) == list(true.columns)
    for name, values in found.columns.items():
        np.testing.assert_array_equal(values, true.columns[name][at])
    return len(found)


def check_honest(found: DataSet | None, said: str, written: Written) -> None:
    """Either refused, or right in every number, with a word for every channel and record that is not all there."""
    assert "\n" not in said
    if found is None:
        return
    true = written.data
    assert (found.neck_yaml, dict(found.clock)) == (true.neck_yaml, dict(true.clock))
    for name in ("state", "fasquelle", "angles", "log", "covariance"):
        one, other = getattr(found, name), getattr(true, name)
        if (0 if one is None else rows_as_written(one, other)) < len(other):
            assert f"/{name} " in said
    for name in ("check", "provenance"):
        if dict(getattr(found, name)) != dict(getattr(true, name)):
            assert dict(getattr(found, name)) == {}
            assert "metadata" in said


@EVERYWHERE
@given(share=st.floats(0, 1, exclude_max=True))
def test_a_file_cut_anywhere_gives_what_is_before(written: Written, share: float) -> None:
    found, said = written.damaged(written.whole[: int(share * len(written.whole))])
    check_honest(found, said, written)
    if found is not None:
        ends = [s.time[-1] for s in (found.state, found.fasquelle, found.angles, found.log)]
        assert np.ptp(ends) < 0.1  # rows that are written side by side end together, within a row of the slowest
        assert "is cut off" in said or len(found.state) == len(written.data.state)


@EVERYWHERE
@given(share=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
def test_a_flipped_bit_loses_a_chunk_at_most(written: Written, share: float, bit: int) -> None:
    content = bytearray(written.whole)
    content[int(share * len(content))] ^= 1 << bit
    found, said = written.damaged(bytes(content))
    check_honest(found, said, written)


def test_no_part_of_a_file_is_unguarded(tmp_path: Path) -> None:
    """A few rows, so that what is around them has its share: every fifth byte, each bit in turn."""
    path, data = tmp_path / "dataset.mcap", data_set(0.01)
    write_dataset(data, path)
    few = Written(data, path.read_bytes(), path)
    for at in range(0, len(few.whole), 5):
        content = bytearray(few.whole)
        content[at] ^= 1 << (at // 5) % 8
        check_honest(*few.damaged(bytes(content)), few)


@EVERYWHERE
@given(share=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7), cut=st.floats(0, 1))
def test_both_at_once(written: Written, share: float, bit: int, cut: float) -> None:
    content = bytearray(written.whole[: int(cut * len(written.whole))])
    if content:
        content[int(share * len(content))] ^= 1 << bit
    found, said = written.damaged(bytes(content))
    check_honest(found, said, written)


def chunks(content: bytes) -> list[tuple[int, Chunk]]:
    """Where the chunks' packed bytes begin, and the chunks."""
    found = [r for r in StreamReader(io.BytesIO(content), emit_chunks=True).records if isinstance(r, Chunk)]
    return [(content.index(chunk.data), chunk) for chunk in found]


def test_a_broken_chunk_leaves_a_hole_that_is_named_and_never_bridged(written: Written) -> None:
    """Of four chunks the second is broken: the first quarter goes with it, as no even clock leads across."""
    places = chunks(written.whole)
    assert len(places) >= 4
    at, chunk = places[1]
    content = bytearray(written.whole)
    content[at + len(chunk.data) // 2] ^= 16
    found, said = written.damaged(bytes(content))
    assert found is not None
    assert "a chunk at byte" in said
    assert "without 10" in said
    np.testing.assert_allclose(np.diff(found.state.time), 0.002, atol=1e-9)
    assert found.state.time[-1] == written.data.state.time[-1]
    assert 0.4 * len(written.data.state) < len(found.state) < 0.8 * len(written.data.state)
    assert len(found.log) > len(found.state)  # what came in keeps its rows on both sides of the hole


def test_the_first_chunk_takes_the_channels_with_it_only_where_the_index_is_lost_too(written: Written) -> None:
    at, chunk = chunks(written.whole)[0]
    content = bytearray(written.whole)
    content[at + len(chunk.data) // 2] ^= 16
    found, said = written.damaged(bytes(content))
    assert found is not None
    assert len(found.state) > 500
    check_honest(found, said, written)
    nothing, why = written.damaged(bytes(content[:-40]))
    assert nothing is None
    assert "description is lost" in why


def test_lengths_that_are_wrong_are_passed_over_by_the_index(written: Written) -> None:
    at, chunk = chunks(written.whole)[1]
    begin = written.whole.rindex(struct.pack("<Q", chunk.message_start_time), 0, at) - 9
    assert written.whole[begin] == 6
    for change in (-5, 5, 1 << 40):
        content = bytearray(written.whole)
        (length,) = struct.unpack_from("<Q", content, begin + 1)
        struct.pack_into("<Q", content, begin + 1, length + change)
        found, said = written.damaged(bytes(content))
        assert found is not None
        check_honest(found, said, written)
        assert found.state.time[-1] == written.data.state.time[-1]


def test_a_whole_file_says_nothing(written: Written) -> None:
    written.path.write_bytes(written.whole)
    with warnings.catch_warnings():
        warnings.simplefilter("error", Recovered)
        check_honest(read_dataset(written.path), "", written)


def test_a_library_user_hears_of_it_too(written: Written) -> None:
    written.path.write_bytes(written.whole[: len(written.whole) // 2])
    with pytest.warns(Recovered, match=r"dataset\.mcap: is cut off; /state has \d+ of 1000 rows"):
        read_dataset(written.path)


def log_of(path: Path, compression: CompressionType, crcs: bool = True, data_crc: bool = False) -> dict[str, int]:
    """A log as other people's loggers leave it: how many rows each of its files should hold."""
    with path.open("wb") as stream:
        writer = Writer(
            stream,
            chunk_size=4000,
            compression=compression,
            enable_crcs=crcs,
            use_chunking=not data_crc,
            enable_data_crcs=data_crc,
        )
        writer.start("ros2")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/joint_states", "json", schema)
        for k in range(200):
            row = {"header": {"stamp": {"sec": k, "nanosec": 0}}, "name": ["m1"], "position": [k * 1.5]}
            writer.add_message(channel, k, json.dumps(row).encode(), k)
        writer.finish()
    return {"joint_states": 200}


@pytest.mark.parametrize("compression", list(CompressionType))
def test_other_peoples_logs_are_recovered_in_every_packing(tmp_path: Path, compression: CompressionType) -> None:
    path = tmp_path / "log.mcap"
    log_of(path, compression)
    whole = path.read_bytes()
    assert len(joint_state.read(path).logs["joint_states"].time) == 200
    path.write_bytes(whole[: len(whole) * 2 // 3])
    with pytest.warns(Recovered, match=r"is cut off; /joint_states has \d+ rows, 0\.00 to \d+\.00 s"):
        log = joint_state.read(path).logs["joint_states"]
    assert 50 < len(log.time) < 200
    np.testing.assert_array_equal(log.position[:, 0], 1.5 * log.time)


def test_numbers_without_a_checksum_of_their_own_stand_or_fall_with_the_whole_file(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    log_of(path, CompressionType.NONE, data_crc=True)
    content = bytearray(path.read_bytes())
    content[content.index(b"[75.0]") + 1] ^= 1
    path.write_bytes(content)
    with pytest.raises(Refused, match="checksum over all data"):
        joint_state.read(path)


@pytest.mark.parametrize("packing", ["zstd", "lz4", "stored"])
def test_chunks_that_unpack_to_more_than_they_say_are_not_unpacked(tmp_path: Path, packing: str) -> None:
    """The frame's own header promises 64 MiB; the chunk 1000 bytes. Then one that owns up to 2 GiB."""
    zeros = bytes(1 << 26)
    packed = {"zstd": zstandard.compress(zeros), "lz4": lz4.frame.compress(zeros), "stored": zeros[:2000]}[packing]
    for size, why in ((1000, "does not unpack to the size"), (1 << 31, "unpacks to 2.0 GiB")):
        name = b"" if packing == "stored" else packing.encode()
        head = struct.pack("<QQQII", 0, 0, size, 0, len(name)) + name
        body = head + struct.pack("<Q", len(packed)) + packed
        path = tmp_path / "bomb.mcap"
        path.write_bytes(mcap_index.MAGIC + struct.pack("<BQ", 6, len(body)) + body)
        with pytest.raises(Refused, match=why):
            joint_state.read(path)
