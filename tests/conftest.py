"""One browser for all tests of pages, which tests the quick lane leaves out, their order, and which go to one core."""

import hashlib
import shutil
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, sync_playwright

from tests.commit import commit
from tests.skips import (  # noqa: F401 (hooks)
    pytest_collectreport,
    pytest_runtest_logreport,
    pytest_sessionfinish,
    pytest_terminal_summary,
)
from tests.slow import FIRST, LONGEST, QUICK, SLOW, TOGETHER, is_slow, together
from tests.time_limit import pytest_addoption, pytest_runtest_setup  # noqa: F401 (hooks)

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


@pytest.fixture(scope="module")
def browser_page() -> Iterator[Page]:
    if BROWSER is None:
        pytest.skip("no chromium, chromium-browser or google-chrome on this machine")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        )
        yield browser.new_page()
        browser.close()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Marks the slow tests, and says which begin.

    Begun with the longest, no core waits for another's last. Where time is limited the order is another at every commit, so that
    no test is always among those that are left out.
    """
    here = Path(__file__).parent
    if missing := [name for name in (*SLOW, *QUICK, *LONGEST, *chain(*TOGETHER), FIRST) if not (here / name).exists()]:
        raise pytest.UsageError(f"{', '.join(missing)}: named in tests/slow.py, and not there")
    paths = {item.path for item in items}
    of_slow = {path for path in paths if is_slow(path.relative_to(here).as_posix())}
    of_longest = {path for path in paths if any(path.is_relative_to(here / place) for place in LONGEST)}
    for item in items:
        if item.path in of_slow:
            item.add_marker(pytest.mark.slow)
    if config.getoption("--seconds") is None:
        items.sort(key=lambda item: item.path not in of_longest)
    else:
        items.sort(key=lambda item: order_of_commit(together(item.path.relative_to(here.parent).as_posix())))


def order_of_commit(group: str) -> tuple[bool, str]:
    """Where tests that go to one core begin in a run whose time is limited."""
    return group != together(f"tests/{FIRST}"), hashlib.sha256(f"{commit()} {group}".encode()).hexdigest()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Where files go to cores as wholes, those that share what takes long go to the same one."""
    if config.getvalue("dist") != "loadfile":
        return None
    from tests.by_shared_setup import BySharedSetup

    return BySharedSetup(config, log)
