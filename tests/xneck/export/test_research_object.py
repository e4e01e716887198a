"""A package for an archive says truly what is in it, and what nobody said of it."""

import hashlib
import json
import zipfile
from pathlib import Path
from typing import Any

import pytest

from tests.command import run
from xneck.export.crate_metadata import METADATA, PackageOptions
from xneck.export.research_object import write_package
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_text
from xneck_foundation.whole_file import write_text

ORCID = "0000-0002-1825-0097"
"""of ORCID's own fictitious person"""
OPTIONS = PackageOptions(licence="CC-BY-4.0", authors=(f"Josiah Carberry <{ORCID}>", "A. Person"), date="2026-01-31")


@pytest.fixture
def results(tmp_path: Path) -> Path:
    """Two recordings, one of them with a record, that were made from a log; a file by hand, a hidden one and a link."""
    folder = tmp_path / "results"
    (folder / "monday").mkdir(parents=True)
    (folder / "by hand").mkdir()
    write_text(folder / "monday/model.yaml", "laws: []\n")
    inputs = {"log": {"file": "log.csv", "bytes": 7, "sha256": "ab" * 32}, "neck": _entry(folder / "monday/model.yaml")}
    made_from = {"xneck": "0.0.9", "python": "3.11", "libraries": {"numpy": "2.4.6", "av": None}, "inputs": inputs}
    write_text(folder / "monday/result.json", json_text({"made_from": made_from}))
    (folder / "by hand/notes ü.txt").write_text("mine")
    (folder / ".hidden").write_text("x")
    (folder / "link.txt").symlink_to(tmp_path / "elsewhere")
    return folder


def _entry(path: Path) -> dict[str, Any]:
    content = path.read_bytes()
    return {"file": path.name, "bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}


def entities(package: Path) -> dict[str, dict[str, Any]]:
    with zipfile.ZipFile(package) as archive:
        document = json.loads(archive.read(METADATA))
    assert document["@context"][0] == "https://w3id.org/ro/crate/1.1/context"
    found = {entity["@id"]: entity for entity in document["@graph"]}
    assert len(found) == len(document["@graph"]), "each entity once"
    return found


def referred(value: Any) -> set[str]:
    """Identities that an entity refers to."""
    if isinstance(value, dict):
        return {value["@id"]} if set(value) == {"@id"} else set().union(*map(referred, value.values()), set())
    return set().union(*map(referred, value), set()) if isinstance(value, list) else set()


def test_the_metadata_is_of_the_files_in_it(results: Path, tmp_path: Path) -> None:
    package = tmp_path / "package.zip"
    record = write_package(results, package, OPTIONS)
    found = entities(package)
    assert found[METADATA]["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert found[METADATA]["about"] == {"@id": "./"}
    root = found["./"]
    assert (root["@type"], root["name"], root["datePublished"]) == ("Dataset", "results", "2026-01-31")
    with zipfile.ZipFile(package) as archive:
        assert archive.testzip() is None
        names = set(archive.namelist())
        assert names == {"monday/model.yaml", "monday/result.json", "by hand/notes ü.txt", METADATA}
        parts = {part["@id"] for part in root["hasPart"]}
        assert parts == {"monday/model.yaml", "monday/result.json", "by%20hand/notes%20%C3%BC.txt"}
        content = archive.read("monday/model.yaml")
    of_model = found["monday/model.yaml"]
    assert of_model["contentSize"] == str(len(content))
    assert of_model["sha256"] == hashlib.sha256(content).hexdigest()
    assert "Not written by xneck" in found["by%20hand/notes%20%C3%BC.txt"]["description"]
    # all that is referred to is there
    own = {identity for entity in found.values() for identity in referred([v for k, v in entity.items() if k != "@id"])}
    assert own - set(found) == {"https://w3id.org/ro/crate/1.1"}
    assert record["left_out"] == [".hidden", "link.txt"]


def test_what_a_file_was_made_from_is_in_it(results: Path, tmp_path: Path) -> None:
    """An input that lies in the package is referred to there; one that does not is described."""
    write_package(results, tmp_path / "package.zip", OPTIONS)
    found = entities(tmp_path / "package.zip")
    (made,) = [entity for entity in found.values() if entity["@type"] == "CreateAction"]
    assert {each["@id"] for each in made["result"]} == {"monday/model.yaml", "monday/result.json"}
    outside, inside = (each["@id"] for each in made["object"])
    assert (found[outside]["name"], found[outside]["sha256"]) == ("log.csv", "ab" * 32)
    assert inside == "monday/model.yaml"
    software = found[made["instrument"]["@id"]]
    assert (software["name"], software["version"]) == ("xneck", "0.0.9")
    assert software["softwareRequirements"] == "Python 3.11, numpy 2.4.6"


def test_an_edited_record_says_nothing(results: Path, tmp_path: Path) -> None:
    record = results / "monday/result.json"
    record.write_text(record.read_text().replace("log.csv", "lag.csv"))
    written = write_package(results, tmp_path / "package.zip", OPTIONS)
    found = entities(tmp_path / "package.zip")
    assert not [entity for entity in found.values() if entity["@type"] == "CreateAction"]
    assert any("monday/result.json" in line for line in written["missing"])


def test_whose_it_is_and_what_one_may_do_with_it(results: Path, tmp_path: Path) -> None:
    write_package(results, tmp_path / "package.zip", OPTIONS)
    found = entities(tmp_path / "package.zip")
    assert found["./"]["license"] == {"@id": "https://spdx.org/licenses/CC-BY-4.0"}
    authors = [found[author["@id"]] for author in found["./"]["author"]]
    assert [author["name"] for author in authors] == ["Josiah Carberry", "A. Person"]
    assert authors[0]["@id"] == f"https://orcid.org/{ORCID}"


def test_what_nobody_said_is_named(results: Path, tmp_path: Path) -> None:
    record = write_package(results, tmp_path / "package.zip", PackageOptions())
    root = entities(tmp_path / "package.zip")["./"]
    assert "license" not in root
    assert "author" not in root
    assert "no licence" in record["missing"][0]
    assert "no author" in record["missing"][1]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (PackageOptions(licence="free for all"), "neither an SPDX name nor an address"),
        (PackageOptions(authors=(f"J <{ORCID[:-1]}8>",)), "is no ORCID"),
        (PackageOptions(authors=("<>",)), "is not NAME"),
        (PackageOptions(date="31.1.2026"), "is no date"),
    ],
)
def test_what_cannot_be_read_is_refused(results: Path, tmp_path: Path, options: PackageOptions, words: str) -> None:
    with pytest.raises(Refused, match=words):
        write_package(results, tmp_path / "package.zip", options)
    assert not (tmp_path / "package.zip").exists()


def test_a_file_that_grows_while_it_is_packed_is_refused(
    results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = zipfile.ZipFile.open

    def open_while_it_grows(archive: zipfile.ZipFile, entry: Any, *mode: Any, **how: Any) -> Any:
        if entry.filename == "monday/model.yaml":
            with (results / "monday/model.yaml").open("a") as file:
                file.write("parameters: []\n")
        return opened(archive, entry, *mode, **how)

    monkeypatch.setattr(zipfile.ZipFile, "open", open_while_it_grows)
    with pytest.raises(Refused, match=r"model\.yaml: was changed or replaced while it was being read"):
        write_package(results, tmp_path / "package.zip", OPTIONS)
    assert [path.name for path in tmp_path.iterdir()] == ["results"]


def test_the_same_results_are_the_same_bytes_and_replace_their_own_package(results: Path, tmp_path: Path) -> None:
    package = tmp_path / "package.zip"
    write_package(results, package, OPTIONS)
    first = package.read_bytes()
    write_package(results, package, OPTIONS)
    assert package.read_bytes() == first
    package.write_bytes(b"somebody's")
    with pytest.raises(Refused, match="not as xneck wrote it"):
        write_package(results, package, OPTIONS)


@pytest.mark.parametrize(
    ("words", "refusal"),
    [
        (("{results}", "--out", "{results}/package.zip"), "lies in the folder"),
        (("{results}", "--out", "package.tar"), "unknown ending"),
        (("{results}", "{results}", "--out", "package.zip"), "give one folder"),
        (("{results}", "--out", "arm.xml"), "holds no neck.yaml"),
        (("{results}", "--figures", "figures"), "holds no pages"),
    ],
)
def test_the_command_refuses_in_a_line(
    words: tuple[str, ...],
    refusal: str,
    results: Path,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    ran = run(capfd, "export", *(word.format(results=results) for word in words))
    assert (ran.status, len(ran.err.splitlines())) == (1, 1)
    assert refusal in ran.err


@pytest.mark.parametrize("words", [(), ("--out", "a.zip", "--figures", "f")])
def test_one_target_is_asked_for(words: tuple[str, ...], results: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = run(capfd, "export", results, *words)
    assert ran.status == 2
    assert "either --out or --figures" in ran.err
