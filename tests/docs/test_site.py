"""The site is built from the pages as they are, loads nothing from elsewhere, and is not built with a broken link."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# what a browser loads by itself; a link that is clicked is none of these
LOADED = re.compile(
    r"<(?:script|img|link|iframe|source|video|audio)\b[^>]*?\b(?:src|href)\s*=\s*[\"']?(?:https?:)?//[^>]*>", re.I
)
LOADED_BY_STYLE = re.compile(r"(?:url\(\s*[\"']?|@import\s+[\"']?)(?:https?:)?//", re.I)


def built(project: Path, out: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, project / ".ci/site.py", out], capture_output=True, text=True, timeout=60)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("site")
    result = built(ROOT, out)
    assert result.returncode == 0, result.stderr
    return out


def test_every_page_is_there(site: Path) -> None:
    for page in [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs").glob("*.ipynb")]:
        name = "index" if page.stem == "README" else page.stem
        assert (site / "docs" / f"{name}.html").is_file(), page
    assert "</h1>" in (site / "index.html").read_text(encoding="utf-8")


def test_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    pages, styles = list(site.rglob("*.html")), list(site.rglob("*.css"))
    assert len(pages) > 20
    assert styles
    for page in pages:
        # the address of the page itself, where one is set, is loaded by nobody
        loaded = [tag for tag in LOADED.findall(page.read_text(encoding="utf-8")) if 'rel="canonical"' not in tag]
        assert not loaded, (page, loaded)
    for style in styles:
        assert not LOADED_BY_STYLE.search(style.read_text(encoding="utf-8")), style


@pytest.mark.parametrize(
    "tag",
    [
        '<script src="https://cdn.example/a.js"></script>',
        '<img alt="" src="http://example.org/a.png"/>',
        "<link rel=stylesheet href=//example.org/a.css>",
    ],
)
def test_what_would_be_loaded_is_noticed(tag: str) -> None:
    assert LOADED.search(tag)
    assert not LOADED.search('<a href="https://example.org/">there</a> <script src="../js/base.js"></script>')


def test_marks_of_figures_are_gone(site: Path) -> None:
    for page in site.rglob("*.html"):
        assert "<!--figure" not in page.read_text(encoding="utf-8"), page
    assert "&lt;!--figure NAME--&gt;" in (site / "docs/development.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("link", ["[gone](nowhere.md)", "[gone](recording.md#no-such-heading)"])
def test_a_broken_link_fails(tmp_path: Path, link: str) -> None:
    project = tmp_path / "project"
    for pattern in (
        "*.md",
        "mkdocs.yml",
        ".ci/site.py",
        "NOTICE",
        "LICENSE",
        "CITATION.cff",
        "docs/**/*",
        "benchmarks/**/*",
    ):
        for file in filter(Path.is_file, ROOT.glob(pattern)):
            copy = project / file.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(file.read_bytes())
    whole = built(project, tmp_path / "whole")
    assert whole.returncode == 0, whole.stderr
    with (project / "docs/viewers.md").open("a", encoding="utf-8") as page:
        page.write(f"\n{link}\n")
    broken = built(project, tmp_path / "broken")
    assert broken.returncode == 1
    assert "docs/viewers.md" in broken.stderr


def test_no_table_falls_apart(site: Path) -> None:
    """A row outside its table becomes a paragraph that begins with a bar."""
    for page in site.rglob("*.html"):
        assert "<p>|" not in page.read_text(encoding="utf-8"), page


def test_every_own_style_is_there(site: Path) -> None:
    for page in site.rglob("*.html"):
        for style in re.findall(r'<link [^>]*href="([^":?#]+\.css)"', page.read_text(encoding="utf-8")):
            root = site if style.startswith("/") else page.parent
            assert (root / style.lstrip("/")).is_file(), (page, style)
