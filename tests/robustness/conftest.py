"""What is damaged here, made once, and the last line of a session."""

from pathlib import Path

import pytest

from samples.generator.hidden.experiment import hide
from tests.robustness.judge import TRIED, run
from tests.robustness.sources import small_files


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """8 s of an arm and its camera, and what sync and identify make of them: d.mcap, m.yaml."""
    folder = tmp_path_factory.mktemp("recorded")
    hide((), 7200, folder, seconds=(8.0, 8.0))
    f = folder / "fitted"
    made = run("whole", "sync", f / "angles.csv", f / "log.csv", "--neck", f / "neck.yaml", "--out", f / "d.mcap")
    assert made.status == 0, made.err
    made = run("whole", "identify", f / "d.mcap", "--out", f / "m.yaml")
    assert made.status == 0, made.err
    return f


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory, recorded: Path) -> Path:
    """A file of every kind that is read, as short as can be, so that every part of it is hit."""
    return small_files(tmp_path_factory.mktemp("small"), recorded)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """How many cases of which kind; what failed is told by the tests."""
    if TRIED:
        kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(TRIED.items()))
        failed = len([r for r in terminalreporter.stats.get("failed", []) if "robustness" in r.nodeid])
        word = f"{failed} tests failed" if failed else "none with a traceback, a hang or a partial output"
        terminalreporter.write_line(f"robustness: {sum(TRIED.values())} cases tried, {word} ({kinds})")
