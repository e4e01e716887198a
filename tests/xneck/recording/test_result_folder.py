"""Partly written files go with the results, and nothing else."""

import shutil
from pathlib import Path

from xneck.recording.result_folder import remove_partial_files, remove_results
from xneck_foundation.whole_file import whole_file


def test_what_a_killed_writer_left_goes_with_the_results(tmp_path: Path) -> None:
    """A part as whole_file itself makes it, of every output; what the writer still holds stays, and a person's own files."""
    for name in ("dataset.mcap", "report.html"):
        with whole_file(tmp_path / name) as part:
            left = part.with_name(part.name[: -len(part.suffix) - 8] + "0a1b2c3d" + part.suffix)
            shutil.copy(part, left)
            remove_partial_files(tmp_path)
            assert part.exists()
            assert not left.exists()
    (tmp_path / ".report-of-mine.html").touch()
    remove_results(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".report-of-mine.html"]
