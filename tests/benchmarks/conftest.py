"""The browser that the tests of other pages use."""

from tests.vision.conftest import browser_page

__all__ = ["browser_page"]
