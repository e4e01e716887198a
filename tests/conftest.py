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
    "benchmarks/test_clean_arms.py",
    "benchmarks/test_growth.py",
    "benchmarks/test_page.py",
    "benchmarks/test_peers.py",
    "calibration/test_bundle_adjustment.py",
    "calibration/test_camera_check.py",
    "calibration/test_estimation.py",
    "calibration/test_observations.py",
    "calibration/test_real_data.py",
    "calibration/test_rendered_bow.py",
    "calibration/test_sheets.py",
    "diagnosis",
    "discovery/test_discover.py",
    "docs",
    "identification/design",
    "identification/simulation",
    "identification/test_estimates.py",
    "identification/test_instruments.py",
    "identification/test_motor_speeds.py",
    "identification/test_recovery.py",
    "mechanism/test_mujoco_peer.py",
    "mechanism/test_simulation.py",
    "mechanism/test_unlisted_laws.py",
    "observation",
    "robustness",
    "samples",
    "state_estimation/test_elongation_law.py",
    "state_estimation/test_fast_motion.py",
    "state_estimation/test_state.py",
    "synchronisation/check",
    "synchronisation/clocks",
    "synchronisation/test_rates.py",
    "test_without_camera.py",
    "vision/linkage",
    "vision/markers",
    "xneck/batch",
    "xneck/cli",
    "xneck/report",
    "xneck/study/test_run_cases.py",
    "xneck/test_without_opencv.py",
    "xneck/viewers",
)
"""files and folders whose tests take more than about five seconds of one core together: `make check` leaves them to `make test`"""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Marks the slow tests."""
    here = Path(__file__).parent
    slow = [here / name for name in SLOW]
    if missing := [str(place) for place in slow if not place.exists()]:
        raise pytest.UsageError(f"{', '.join(missing)}: named slow, and not there")
    for item in items:
        if any(item.path.is_relative_to(place) for place in slow):
            item.add_marker(pytest.mark.slow)
