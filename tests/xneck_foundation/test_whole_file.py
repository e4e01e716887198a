"""An output appears whole or not at all."""

from pathlib import Path

import pytest

from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import whole_file, write_text


def test_an_error_half_way_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    write_text(file, "old")
    before = file.read_bytes()

    def half() -> None:
        with whole_file(file) as part:
            part.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        half()
    assert file.read_bytes() == before
    assert list(tmp_path.iterdir()) == [file]


def test_a_finished_block_replaces_the_file(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    write_text(file, "old")
    write_text(file, "new")
    assert file.read_text().startswith("new\n")
    assert list(tmp_path.iterdir()) == [file]


def test_places_that_cannot_be_written_are_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="does not exist"):
        write_text(tmp_path / "no" / "a.yaml", "x")
    with pytest.raises(Refused, match="is a folder"):
        write_text(tmp_path, "x")
