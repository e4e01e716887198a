"""The hashes of a result are those of the bytes that were read for it."""

import hashlib
import os
from pathlib import Path

import pytest

from xneck_foundation.errors import Refused
from xneck_foundation.provenance import note_inputs, provenance


def test_name_size_and_hash_of_each_input(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_bytes(b"time\n")
    entry = provenance(note_inputs({"log": tmp_path / "log.csv"}), {"x": 1})
    assert entry["inputs"]["log"] == {"file": "log.csv", "bytes": 5, "sha256": hashlib.sha256(b"time\n").hexdigest()}
    assert entry["settings"] == {"x": 1}


@pytest.mark.parametrize("change", ["other size", "same size", "replaced", "link"])
def test_an_input_that_is_another_after_it_was_read_is_refused(tmp_path: Path, change: str) -> None:
    path, other = tmp_path / "log.csv", tmp_path / "other.csv"
    path.write_bytes(b"time\n")
    other.write_bytes(b"emit\n")
    os.utime(path, ns=(0, 10**18))
    os.utime(other, ns=(0, 10**18))
    inputs = note_inputs({"log": path})
    provenance(inputs)
    if change == "other size":
        path.write_bytes(b"time,theta1\n")
        os.utime(path, ns=(0, 10**18))
    elif change == "same size":
        path.write_bytes(b"emit\n")
    elif change == "replaced":
        other.replace(path)
    else:
        path.unlink()
        path.symlink_to(other)
    with pytest.raises(Refused, match=r"log.csv: was changed or replaced while it was being read"):
        provenance(inputs)


def test_an_input_that_is_gone_or_no_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_bytes(b"time\n")
    inputs = note_inputs({"log": tmp_path / "log.csv"})
    (tmp_path / "log.csv").unlink()
    with pytest.raises(Refused, match=r"log.csv: does not exist"):
        provenance(inputs)
    with pytest.raises(Refused, match="is a folder"):
        note_inputs({"log": tmp_path})
