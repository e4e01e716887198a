"""CITATION.cff has what the Citation File Format 1.2.0 asks for, and the version of the package."""

import re
import tomllib

import yaml

from tests.paths import ROOT

CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
KEYS = {
    "abstract", "authors", "cff-version", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license",
    "license-url", "message", "preferred-citation", "references", "repository", "repository-artifact", "repository-code", "title",
    "type", "url", "version",
}  # fmt: skip
"""those that the format knows"""


def test_what_the_format_asks_for_is_there() -> None:
    assert set(CITATION) <= KEYS
    assert CITATION["cff-version"] == "1.2.0"
    assert CITATION["type"] == "software"
    assert CITATION["message"]
    for work in (CITATION, *CITATION["references"]):
        assert work["title"]
        assert all({"name", "family-names"} & set(author) for author in work["authors"])
    assert all(work["type"] for work in CITATION["references"])


def test_it_is_this_package() -> None:
    assert CITATION["title"] == PROJECT["name"]
    assert str(CITATION["version"]) == PROJECT["version"]
    assert CITATION["license"] == PROJECT["license"]
    assert re.sub(r"\s+", " ", CITATION["abstract"]).strip(" .") == PROJECT["description"]
