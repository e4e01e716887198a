"""Builds the site: python .ci/site.py FOLDER. The pages keep their places, the notebook becomes a page, a broken link fails."""

import logging
import re
import shutil
import sys
import tempfile
from pathlib import Path

import nbformat
from mkdocs.commands.build import build
from mkdocs.config import load_config
from mkdocs.exceptions import Abort

PROJECT = Path(__file__).parents[1]
PAGES = ["README.md", "CHANGELOG.md", "SECURITY.md", "docs/*.md", "benchmarks/*.md"]
AS_THEY_ARE = [
    "NOTICE",
    "LICENSE",
    "CITATION.cff",
    "docs/images/*.png",
    "docs/site/*.css",
    "benchmarks/record/*.json",
    "benchmarks/tuned_seeds.py",
]
NOTEBOOK = "docs/tutorial.ipynb"
# a placeholder of a figure, but not where a page shows one in code
COMMENT = re.compile(r"(`[^`]*`)|<!--.*?-->", re.DOTALL)


def page(text: str) -> str:
    """A page as MkDocs takes it: no marks around figures, which would begin a block, and links to the notebook's page."""
    return COMMENT.sub(lambda found: found[1] or "", text).replace("tutorial.ipynb)", "tutorial.md)")


def notebook_page(file: Path) -> str:
    """The cells of a notebook in Markdown, code in fences."""
    cells = nbformat.read(file, as_version=4).cells
    return "\n\n".join(f"```python\n{cell.source}\n```" if cell.cell_type == "code" else cell.source for cell in cells)


def lay_out(place: Path) -> None:
    """Puts into ``place`` what the site consists of, each file where it lies in the project."""
    for pattern in [*PAGES, *AS_THEY_ARE]:
        for file in sorted(PROJECT.glob(pattern)):
            copy = place / file.relative_to(PROJECT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            if pattern in PAGES:
                copy.write_text(page(file.read_text(encoding="utf-8")), encoding="utf-8")
            else:
                shutil.copyfile(file, copy)
    (place / NOTEBOOK).with_suffix(".md").write_text(page(notebook_page(PROJECT / NOTEBOOK)), encoding="utf-8")


def build_site(out: Path) -> None:
    """Writes the site into the folder ``out``.

    Raises:
        Abort: a link leads nowhere, or a page is in no menu
    """
    with tempfile.TemporaryDirectory() as place:
        lay_out(Path(place))
        build(load_config(str(PROJECT / "mkdocs.yml"), docs_dir=place, site_dir=str(out.resolve()), strict=True))


if __name__ == "__main__":
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    try:
        build_site(Path(sys.argv[1]))
    except Abort as error:
        sys.exit(f"the site was not built: {error}")
