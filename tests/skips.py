"""Tests may be skipped for the reasons listed here only: any other skip fails the run, so that none goes unnoticed.

`tests/conftest.py` takes the hooks.
"""

import re

import pytest

from tests.time_limit import NO_TIME, say_what_was_left_out

ALLOWED = {
    r"no chromium, chromium-browser or google-chrome on this machine": "a browser cannot be had without a package manager",
    r"needs strace": "system calls can only be watched where strace is",
    r"nothing is read-only for root": "`make other-user` runs these tests as another user",
    r"no real data (at|in) .*": "pictures and videos whose licence keeps them out of the repository",
    r"shared data not beside the checkout": "the same",
    r"needs node, and Foxglove's packages from npm under NODE_PATH": "npm needs a network",
    r"could not import '(pandas|xarray)': .*": "extras, which an environment of an earlier day lacks",
    r"BLAS has no three threads here": "a machine with fewer cores",
    NO_TIME: "of machines that are several times slower than usual, and said at the end",
}
"""reasons, as regular expressions, each with why it may stand"""

_unlisted: list[str] = []


def may_skip(reason: str) -> bool:
    """Whether a test may be skipped for a reason."""
    return any(re.fullmatch(pattern, reason) for pattern in ALLOWED)


def _note(report: pytest.TestReport | pytest.CollectReport) -> None:
    if not report.skipped or hasattr(report, "wasxfail"):
        return
    said = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    reason = str(said).removeprefix("Skipped: ")
    if not may_skip(reason):
        _unlisted.append(f"{report.nodeid}: {reason}")


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    _note(report)


def pytest_collectreport(report: pytest.CollectReport) -> None:
    _note(report)


def pytest_sessionfinish(session: pytest.Session) -> None:
    if _unlisted and not hasattr(session.config, "workerinput") and session.exitstatus in (0, 5):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    say_what_was_left_out(terminalreporter)
    if _unlisted:
        terminalreporter.section("skipped for reasons that tests/skips.py does not list")
        for line in _unlisted:
            terminalreporter.line(line)
