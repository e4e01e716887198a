"""What docstrings and pages show is what happens."""

import ast
import doctest
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import click
import pytest

import xneck
from tests.docs.pages import PAGES, ROOT, commands, fenced
from xneck.cli import COMMANDS, group

SHOWN = {"xneck": xneck} | {name: getattr(xneck, name) for name in xneck.__all__ if name != "Refused"}


@pytest.mark.parametrize("name", SHOWN)
def test_every_function_shows_an_example_that_runs(name: str, in_examples: Path) -> None:
    examples = doctest.DocTestParser().get_doctest(SHOWN[name].__doc__ or "", {}, name, None, None)
    assert examples.examples
    said: list[str] = []
    doctest.DocTestRunner(verbose=False).run(examples, out=said.append)
    assert not said, "".join(said)


def test_what_the_readme_diagnoses_is_what_the_sample_hides(in_examples: Path) -> None:
    """What neck.yaml does not know is named, weighed, and gone from the recording that was not fitted."""
    (block,) = fenced("README.md", "python")
    names: dict[str, Any] = {}
    exec(compile(block, "README.md", "exec"), names)
    found = xneck.as_record(names["diagnosis"])
    assert found["verdict"] == "cause"
    (cause,) = found["causes"]
    assert cause["effect"] == "tip_payload"
    mass, *place = cause["parameters"]
    assert [p["name"] for p in place] == ["xm", "ym"]
    true = json.loads((ROOT / "samples/truth.json").read_text())["recording"]["hidden"]["load"]["payload_kg"]
    assert abs(mass["value"] - true) < 3 * mass["sigma"]
    assert mass["identified"]
    for gain in found["gains"]:
        assert gain["before"] - gain["after"] > 3 * gain["gain_sigma"]
        assert gain["after"] < 0.5 * gain["before"]


def test_an_example_that_does_not_hold_is_noticed() -> None:
    said: list[str] = []
    wrong = doctest.DocTestParser().get_doctest(">>> 1 + 1\n3\n", {}, "wrong", None, None)
    doctest.DocTestRunner(verbose=False).run(wrong, out=said.append)
    assert said


def test_names_for_type_checkers_are_those_that_are_fetched() -> None:
    """The imports that only a type checker sees give the same names from the same places."""
    tree = ast.parse(Path(xneck.__file__).read_text(encoding="utf-8"))
    (guarded,) = [node for node in tree.body if isinstance(node, ast.If)]
    seen = {
        alias.asname or alias.name: f"{node.module}:{alias.name}"
        for node in guarded.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert seen == xneck._LOCATIONS
    assert set(xneck.__all__) == {*seen, "Refused"}
    assert set(xneck.__all__) <= set(dir(xneck))


def test_importing_it_loads_nothing_else() -> None:
    """Every command imports it, and `xneck --help` is not to wait for numpy."""
    loaded = "import sys, xneck; print(*{name.split('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", loaded], capture_output=True, text=True, check=True, cwd=ROOT)
    assert not set(done.stdout.split()) & {"numpy", "vision", "identification", "mechanism", "calibration"}


def test_what_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'diagnosis'"):
        xneck.diagnosis  # type: ignore[attr-defined]  # noqa: B018


@pytest.mark.parametrize("page", PAGES)
def test_pythons_blocks_run(page: str, in_examples: Path) -> None:
    """One after the other, as a reader would; those that begin with a file's path are files of new-effect.md."""
    names: dict[str, object] = {}
    for block in fenced(page, "python"):
        if not block.startswith("# "):
            exec(compile(block, page, "exec"), names)


@pytest.mark.parametrize(
    "line", [pytest.param(line, id=f"{page}: {line}") for page in PAGES for line in commands(page)]
)
def test_every_command_parses(line: str) -> None:
    """Names of commands and options are right; the files of the example are not there."""
    _, name, *words = line.split("#")[0].split()
    command = group.get_command(click.Context(group), name)
    assert command is not None
    command.make_context(name, words, resilient_parsing=False)


def test_the_readme_shows_the_main_commands() -> None:
    assert {line.split()[1] for line in commands("README.md")} >= {
        "board", "calibrate", "extract", "sync", "check", "identify", "diagnose", "run",
    }  # fmt: skip
    assert set(re.findall(r"(?:`|^ +)xneck ([a-z]+)", PAGES["README.md"], flags=re.MULTILINE)) <= set(COMMANDS)


def test_the_readme_is_short_and_has_a_picture() -> None:
    page = PAGES["README.md"]
    assert 90 <= len(page.splitlines()) <= 120
    (picture,) = re.findall(r"!\[[^]]+\]\(([^)]+)\)", page)
    assert (ROOT / picture).read_bytes().startswith(b"\x89PNG")
    assert (ROOT / picture).stat().st_size < 200_000


def test_the_contents_page_leads_to_every_page() -> None:
    names = {page.name for page in (ROOT / "docs").iterdir() if page.is_file()} - {"README.md"}
    assert set(re.findall(r"\]\(([^)#]+)\)", PAGES["docs/README.md"])) == names


@pytest.mark.parametrize("page", PAGES)
def test_make_targets_are_there(page: str) -> None:
    makefile = (ROOT / "Makefile").read_text()
    for target in re.findall(r"(?:`|^ +)make ([a-z-]+)", PAGES[page], flags=re.MULTILINE):
        assert f"\n{target}:" in makefile, target


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    """To files, and to headings of this page or of another."""
    here = (ROOT if page == "README.md" else ROOT / "docs").resolve()
    for target in re.findall(r"\]\(([^)]+)\)", PAGES[page]):
        path, _, heading = target.partition("#")
        assert not path or (here / path).exists(), target
        if heading:
            text = (here / path).read_text(encoding="utf-8") if path else PAGES[page]
            assert heading in headings(text), target


def headings(text: str) -> set[str]:
    """A page's headings as links name them."""
    return {
        re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")
        for heading in re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    }
