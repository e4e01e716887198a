"""The README and docs/, and the blocks in them."""

import re

from tests.paths import ROOT

PAGES = {
    page.name: page.read_text(encoding="utf-8") for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
}


def fenced(page: str, kind: str) -> list[str]:
    """Contents of a page's blocks of that kind."""
    return re.findall(rf"^```{kind}\n(.*?)^```$", PAGES[page], flags=re.MULTILINE | re.DOTALL)


def commands(page: str) -> list[str]:
    """Lines that call xneck."""
    return re.findall(r"^ +(xneck [a-z]+ .+)$", PAGES[page], flags=re.MULTILINE)
