"""`--seconds N`: slow tests that have not begun after N seconds are left out, and counted.

On a machine several times slower than usual all tests take hours. What is left out is said in a line that begins with NOT RUN.

`tests/conftest.py` takes the hooks.
"""

import time

import pytest

NO_TIME = "no time is left for slow tests"

_began = time.monotonic()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--seconds", type=float, default=None, help="leave out slow tests that have not begun by then")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    limit = item.config.getoption("--seconds")
    if limit is not None and time.monotonic() - _began > limit and item.get_closest_marker("slow"):
        pytest.skip(NO_TIME)


def say_what_was_left_out(terminalreporter: pytest.TerminalReporter) -> None:
    skipped = terminalreporter.stats.get("skipped", [])
    count = sum(NO_TIME in str(report.longrepr) for report in skipped)
    if count:
        terminalreporter.write_line("")
        terminalreporter.write_line(f"NOT RUN: {count} slow tests, for which no time was left")
