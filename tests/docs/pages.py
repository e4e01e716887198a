"""The README and docs/, and the blocks in them."""

import re

from tests.paths import ROOT

PAGES = {
    ("docs/README.md" if page == ROOT / "docs/README.md" else page.name): page.read_text(encoding="utf-8")
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
}
"""by file name; the contents page of docs/ by its path"""


def fenced(page: str, kind: str) -> list[str]:
    """Contents of a page's blocks of that kind."""
    return re.findall(rf"^```{kind}\n(.*?)^```$", PAGES[page], flags=re.MULTILINE | re.DOTALL)


def commands(page: str) -> list[str]:
    """Lines that call xneck, and calls in the cells of a table."""
    lines = re.findall(r"^ +(xneck [a-z]+ .+)$", PAGES[page], flags=re.MULTILINE)
    rows = re.findall(r"^\|.*$", PAGES[page], flags=re.MULTILINE)
    return lines + [call for row in rows for call in re.findall(r"`(xneck [a-z]+ [^`]+)`", row)]
