"""One browser for all tests of pages, and which tests the quick lane leaves out."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, sync_playwright

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


SLOW = (
    "benchmarks/test_page.py",
    "calibration/test_camera_check.py",
    "calibration/test_estimation.py",
    "calibration/test_real_data.py",
    "calibration/test_views.py",
    "diagnosis",
    "docs",
    "identification/design",
    "identification/simulation",
    "identification/test_estimates.py",
    "identification/test_recovery.py",
    "mechanism/test_simulation.py",
    "robustness",
    "samples",
    "state_estimation/test_state.py",
    "synchronisation",
    "test_without_camera.py",
    "vision/linkage/test_placement.py",
    "vision/linkage/test_linkage_fit.py",
    "vision/markers/test_hard.py",
    "vision/markers/test_photometric.py",
    "xneck/batch/test_batch.py",
    "xneck/cli/test_demo.py",
    "xneck/cli/test_sample.py",
    "xneck/report",
    "xneck/study/test_running.py",
)
"""files and folders whose tests take more than about five seconds of one core together: `make check` leaves them to `make test`"""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Marks the slow tests."""
    here = Path(__file__).parent
    slow = [here / name for name in SLOW]
    for item in items:
        if any(item.path.is_relative_to(place) for place in slow):
            item.add_marker(pytest.mark.slow)
