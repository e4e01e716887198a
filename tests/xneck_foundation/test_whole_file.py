"""An output appears whole or not at all."""

import os
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


def test_content_is_on_the_disk_before_the_name_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else a power loss leaves an empty file under the name: the file that is moved is synchronised, whole, before it is moved."""
    order: list[tuple[str, int, int]] = []
    fsync, replace = os.fsync, Path.replace

    def noted_fsync(handle: int) -> None:
        order.append(("fsync", os.fstat(handle).st_ino, os.fstat(handle).st_size))
        fsync(handle)

    def noted_replace(self: Path, target: Path) -> Path:
        order.append(("replace", self.stat().st_ino, self.stat().st_size))
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", noted_fsync)
    monkeypatch.setattr(Path, "replace", noted_replace)
    write_text(tmp_path / "a.yaml", "content")
    file = (tmp_path / "a.yaml").stat()
    assert order == [("fsync", file.st_ino, file.st_size), ("replace", file.st_ino, file.st_size)]
    assert file.st_size > len("content")


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_results_are_read_by_a_whole_lab(mask: int, tmp_path: Path) -> None:
    """A temporary file is its owner's only: what takes its place is anybody's to read and nobody else's to write."""
    before = os.umask(mask)
    try:
        write_text(tmp_path / "a.yaml", "content")
    finally:
        os.umask(before)
    assert (tmp_path / "a.yaml").stat().st_mode & 0o777 == 0o644
