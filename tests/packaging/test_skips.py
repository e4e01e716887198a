"""A skip that nobody listed fails the run; one that is listed does not."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests import conftest
from tests.paths import ROOT
from tests.slow import FIRST, together

HOOKS = "pytest_collectreport, pytest_runtest_logreport, pytest_sessionfinish, pytest_terminal_summary"
LISTED, UNLISTED = "needs strace", "too tired"


def run(folder: Path, text: str, *words: str) -> subprocess.CompletedProcess[str]:
    hooks = f"from tests.skips import {HOOKS}\nfrom tests.time_limit import pytest_addoption, pytest_runtest_setup\n"
    (folder / "conftest.py").write_text(hooks, encoding="utf-8")
    (folder / "test_it.py").write_text(f"import pytest\n{text}\n", encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *words, str(folder / "test_it.py")]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("workers", [(), ("-n", "1")])
@pytest.mark.parametrize(("reason", "status"), [(LISTED, 0), (UNLISTED, 1)])
def test_a_skip_is_noticed_unless_it_is_listed(
    reason: str, status: int, workers: tuple[str, ...], tmp_path: Path
) -> None:
    text = f"def test_done(): pass\n@pytest.mark.skip(reason={reason!r})\ndef test_skipped(): pass"
    done = run(tmp_path, text, *workers)
    assert done.returncode == status, done.stdout
    assert ("too tired" in done.stdout and "does not list" in done.stdout) == bool(status)


@pytest.mark.parametrize(("reason", "status"), [(LISTED, 0), (UNLISTED, 1)])
def test_so_is_a_file_that_is_skipped_as_a_whole_and_a_skip_from_within(
    reason: str, status: int, tmp_path: Path
) -> None:
    inside = run(tmp_path, f"def test_one(): pytest.skip({reason!r})\ndef test_two(): pass")
    assert inside.returncode == status, inside.stdout
    whole = run(tmp_path, f"pytest.skip({reason!r}, allow_module_level=True)\ndef test_one(): pass")
    assert whole.returncode in ((0, 5) if status == 0 else (1,)), whole.stdout


@pytest.mark.parametrize("workers", [(), ("-n", "1")])
def test_slow_tests_that_no_time_is_left_for_are_counted_and_the_others_run(
    workers: tuple[str, ...], tmp_path: Path
) -> None:
    text = """
@pytest.mark.slow
def test_slow(): raise AssertionError("it ran")

def test_fast(): pass
"""
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = slow\n", encoding="utf-8")
    limited = run(tmp_path, text, "--seconds", "0", *workers)
    assert limited.returncode == 0, limited.stdout
    assert "1 passed, 1 skipped" in limited.stdout
    assert "\nNOT RUN: 1 slow tests, for which no time was left\n" in limited.stdout
    unlimited = run(tmp_path, text, *workers)
    assert unlimited.returncode == 1
    assert "NOT RUN" not in unlimited.stdout


def test_where_time_is_limited_the_order_is_of_the_commit_and_hidden_effects_come_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    groups = [f"tests/place_{k}/test_it.py" for k in range(20)] + [together(f"tests/{FIRST}")]

    def order(commit: str) -> list[str]:
        monkeypatch.setattr(conftest, "commit", lambda: commit)
        return sorted(groups, key=conftest.order_of_commit)

    one, again, other = order("a" * 40), order("a" * 40), order("b" * 40)
    assert one == again
    assert one != other
    assert one[0] == other[0] == together(f"tests/{FIRST}")
