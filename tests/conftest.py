"""One browser for all tests of pages, and which tests the quick lane leaves out."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, sync_playwright

from tests.skips import (  # noqa: F401 (hooks)
    pytest_collectreport,
    pytest_runtest_logreport,
    pytest_sessionfinish,
    pytest_terminal_summary,
)
from tests.slow import LONGEST, SLOW

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


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Marks the slow tests, and begins with the longest, so that no core waits for another's last."""
    here = Path(__file__).parent
    slow, longest = ([here / name for name in names] for names in (SLOW, LONGEST))
    if missing := [str(place) for place in (*slow, *longest) if not place.exists()]:
        raise pytest.UsageError(f"{', '.join(missing)}: named slow, and not there")
    for item in items:
        if any(item.path.is_relative_to(place) for place in slow):
            item.add_marker(pytest.mark.slow)
    items.sort(key=lambda item: not any(item.path.is_relative_to(place) for place in longest))
