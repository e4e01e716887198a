"""Files that another program writes: half of a line, of a record, or of a file is waited for, and the whole is what was written."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from identification.dataset.series import Series
from mechanism.description import read_neck
from synchronisation.encoder_log import motor_log, read_log
from tests.paths import SAMPLES
from xneck.watch.growing_file import GrowingFile
from xneck.watch.growing_log import GrowingLog
from xneck_foundation.errors import Refused

RECORDING = SAMPLES / "recording"
NECK = read_neck(RECORDING / "neck.yaml")


@pytest.mark.parametrize("name", ["log.csv", "log.mcap"])
def test_a_log_that_comes_in_pieces_is_the_log(tmp_path: Path, name: str) -> None:
    """Pieces end anywhere: in a number, in a record's length, in a chunk."""
    whole = (RECORDING / name).read_bytes()
    path = tmp_path / name
    log = GrowingLog(GrowingFile(path), NECK)
    assert not log.poll()
    cuts = sorted({0, 3, 8, 17, *np.random.default_rng(3).integers(0, len(whole), 40).tolist(), len(whole)})
    rows = []
    with path.open("wb", buffering=0) as stream:
        for begin, end in pairwise(cuts):
            stream.write(whole[begin:end])
            log.poll()
            rows.append(log.rows)
    assert rows == sorted(rows)
    assert len(set(rows)) >= 4  # an MCAP comes by chunks
    grown = log.since(-np.inf)
    assert grown is not None
    same_as(motor_log(grown, NECK, path), read_log(RECORDING / name, NECK))


def same_as(found: Series, expected: Series) -> None:
    np.testing.assert_array_equal(found.time, expected.time)
    assert found.columns.keys() == expected.columns.keys()
    for column, values in expected.columns.items():
        np.testing.assert_array_equal(found.columns[column], values)


def test_only_the_newest_rows_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("xneck.watch.growing_log.MAX_ROWS", 500)
    path = tmp_path / "log.csv"
    log = GrowingLog(GrowingFile(path), NECK)
    lines = (RECORDING / "log.csv").read_bytes().splitlines(keepends=True)[:3001]
    with path.open("wb", buffering=0) as stream:
        for begin in range(0, 3001, 100):
            stream.write(b"".join(lines[begin : begin + 100]))
            log.poll()
    kept = log.since(-np.inf)
    assert kept is not None
    assert log.rows == 3000
    assert 500 <= len(kept) < 700


def test_a_file_that_becomes_shorter_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(b"time,theta1\n1,2\n")
    file = GrowingFile(path)
    assert file.read_available(100)
    path.write_bytes(b"time")
    with pytest.raises(Refused, match="cut or replaced"):
        file.read_available(100)


def test_a_reader_waits_for_bytes_and_is_told_of_the_end(tmp_path: Path) -> None:
    path = tmp_path / "video.mkv"
    waits: list[int] = []

    def wait() -> bool:
        waits.append(1)
        if len(waits) == 2:
            path.write_bytes(b"abc")
        return len(waits) < 4

    file = GrowingFile(path, wait)
    assert file.read(10) == b"abc"
    assert file.read(10) == b""
    assert len(waits) == 4


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time;theta1;theta2;theta3;theta4\n1;2;3;4;5\n", "semicolons"),
        ("time,theta1,theta2,theta3\n1,2,3,4\n", "lacks the column theta4"),
        ("time,theta1,theta2,theta3,theta4\n1,2,3,4,5\n1,2,x,4,5\n", "row 3"),
    ],
)
def test_a_log_that_cannot_be_one_is_refused_with_its_first_rows(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text)
    with pytest.raises(Refused, match=words):
        GrowingLog(GrowingFile(path), NECK).poll()


def test_a_row_is_named_by_its_number_in_the_file_whatever_piece_it_came_in(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    log = GrowingLog(GrowingFile(path), NECK)
    with path.open("wb", buffering=0) as stream:
        stream.write(b"time,theta1,theta2,theta3,theta4\n1,2,3,4,5\n2,2,3,4,5\n")
        log.poll()
        stream.write(b"3,2,3,4,5\n4,2,x,4,5\n")
        with pytest.raises(Refused, match="row 5 is not 5 numbers"):
            log.poll()


def test_a_line_that_is_no_row_of_a_table_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("time," + "x" * 200_000 + "\n1,2\n")
    with pytest.raises(Refused, match="cannot be read as CSV"):
        GrowingLog(GrowingFile(path), NECK).poll()
