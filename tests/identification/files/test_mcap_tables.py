"""Files written from tables are those that the MCAP project's own writer makes, byte for byte at one level of compression."""

from io import BytesIO

import numpy as np
import pytest
import zstandard
from mcap.records import Schema
from mcap.writer import Writer

from identification.files.mcap_records import checksummed
from identification.files.mcap_tables import CHUNK_BYTES, COMPRESSION_LEVEL, FileHead, MessageTable, write_tables

METADATA = {"rows": checksummed("rows", {"fast": 1}), "clock": checksummed("clock", {"offset_s": 0.25})}
ATTACHMENTS = {"neck.yaml": ("application/yaml", b"x: 1"), "a": ("application/octet-stream", b"")}


def tables(counts: tuple[int, ...]) -> list[MessageTable]:
    rng, made = np.random.default_rng(0), []
    for c, count in enumerate(counts):
        messages = rng.integers(0, 256, (count, 100 * (c + 1) + 3), dtype=np.uint8)
        logged = np.sort(rng.integers(0, 10**12, count))
        rows = messages.__getitem__
        made.append(MessageTable(f"/topic{c}", logged, logged + 5, messages.shape[1], rows))
    return made


def by_the_library(head: FileHead, channels: list[MessageTable]) -> bytes:
    stream = BytesIO()
    writer = Writer(stream, chunk_size=CHUNK_BYTES)
    writer.start(head.profile, head.library)
    schema = writer.register_schema(head.schema.name, head.schema.encoding, head.schema.data)
    for name, value in head.metadata.items():
        writer.add_metadata(name, value)
    for name, (kind, content) in head.attachments.items():
        writer.add_attachment(0, 0, name, kind, content)
    ids = [writer.register_channel(table.topic, head.encoding, schema) for table in channels]
    share = [
        ((k + 0.5) / len(table.logged), c, k) for c, table in enumerate(channels) for k in range(len(table.logged))
    ]
    for _, c, k in sorted(share):
        table = channels[c]
        content = table.rows(slice(k, k + 1)).tobytes()
        writer.add_message(ids[c], int(table.logged[k]), content, int(table.published[k]), k)
    writer.finish()
    return stream.getvalue()


@pytest.mark.parametrize("counts", [(3000, 200, 0, 3000), (1,), (2, 5000), (0, 0)])
def test_bytes_are_the_librarys(counts: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mcap.writer.zstandard.compress", zstandard.ZstdCompressor(level=COMPRESSION_LEVEL).compress)
    head = FileHead(
        profile="ros2",
        library="xneck",
        schema=Schema(id=1, name="s", encoding="ros2msg", data=b"d"),
        encoding="cdr",
        metadata=METADATA,
        attachments=ATTACHMENTS,
    )
    stream = BytesIO()
    write_tables(stream, head, tables(counts))
    assert stream.getvalue() == by_the_library(head, tables(counts))
