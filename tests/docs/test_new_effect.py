"""docs/new-effect.md, followed in a copy of the sources, gives an effect that is tested and found."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.pages import PAGES, ROOT, fenced

PAGE = "new-effect.md"
FOLDERS = (
    "xneck", "vision", "synchronisation", "diagnosis", "observation", "state_estimation", "identification", "calibration",
    "discovery",
    "mechanism", "xneck_foundation", "samples", "tests", "docs", "benchmarks",
)  # fmt: skip
FILES = ("pyproject.toml", "README.md", "CHANGELOG.md", "Makefile")


def lines_in(folder: Path, block: str) -> None:
    """Puts the lines with + behind those shown before them; each of these is there once, after the last."""
    first, *rest = block.splitlines()
    path = folder / first.removeprefix("--- ")
    text, at = path.read_text(encoding="utf-8").splitlines(), 0
    for line in rest:
        if line[:1] == "+":
            text.insert(at, line[1:])
            at += 1
        else:
            found = [i for i, known in enumerate(text) if i >= at and known == line[1:]]
            assert len(found) == 1, f"{path.name}: {len(found)} lines {line[1:]!r}"
            at = found[0] + 1
    path.write_text("\n".join(text) + "\n", encoding="utf-8")


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sources with the page's effect in them."""
    folder = tmp_path_factory.mktemp("copy")
    for name in FOLDERS:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "*.mp4", "*.jpg"))
    for name in FILES:
        shutil.copy(ROOT / name, folder)
    for block in fenced(PAGE, "python"):
        path, text = block.split("\n", 1)
        (folder / path.removeprefix("# ")).write_text(text, encoding="utf-8")
    for block in fenced(PAGE, "diff"):
        lines_in(folder, block)
    return folder


def called(folder: Path, *words: object) -> str:
    """Python there, with what is there before what is installed."""
    there = {"PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1"}
    call = [sys.executable, *map(str, words)]
    done = subprocess.run(call, cwd=folder, env=os.environ | there, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def indented(pattern: str) -> str:
    """The page's one command of that pattern."""
    (line,) = re.findall(rf"^    ({pattern})$", PAGES[PAGE], flags=re.MULTILINE)
    return line


def test_the_files_are_clean(followed: Path) -> None:
    """To the linter and the formatter of `make test`."""
    called(followed, "-m", "ruff", "check", "mechanism", "diagnosis", "samples")
    called(followed, "-m", "ruff", "format", "--check", "mechanism", "diagnosis", "samples")


def test_three_files_are_enough() -> None:
    """A law, an effect and a kind of the generator; no list of laws or effects has to be extended."""
    files = [block.splitlines()[0].removeprefix("# ") for block in fenced(PAGE, "python")]
    changed = [block.splitlines()[0].removeprefix("--- ") for block in fenced(PAGE, "diff")]
    assert files == ["mechanism/laws/windage.py", "diagnosis/effects/windage.py"]
    assert changed == ["samples/generator/hidden/effects.py"]


def test_what_is_tested_without_another_line_passes(followed: Path) -> None:
    """And is there: a law, an effect's columns, what it does at nothing, a hidden world."""
    out = called(followed, "-m", *indented("pytest .+").split(), "-q", "-p", "no:cacheprovider")
    assert int(out.split(" passed")[0].split()[-1]) >= 4


def test_the_pages_list_it_once_they_are_written_anew(followed: Path) -> None:
    """And the documents' own tests pass with it."""
    called(followed, *indented("python .+").split()[1:])
    row = "| `windage` | something on the motors' shafts stirs the air | fw (N s^2/rad^2) | turn the motor at speeds"
    assert row in (followed / "docs/verdicts.md").read_text(encoding="utf-8")
    called(followed, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/docs/test_figures.py")


def test_the_effect_is_named_where_it_was_hidden_and_its_numbers_are_judged(followed: Path) -> None:
    """A recording of an arm that stirs the air, by the commands; its seed was chosen before it was run."""
    hide = (
        "from samples.generator.hidden.experiment import hide; hide(['windage'], 7100, Path('w'), seconds=(40.0, 8.0))"
    )
    called(followed, "-c", f"from pathlib import Path; {hide}")
    xneck = ("-m", "xneck")
    here = followed / "w/fitted"
    called(
        followed, *xneck, "sync", here / "angles.csv", here / "log.csv", "--neck", here / "neck.yaml", "--out", "w.mcap"
    )
    called(followed, *xneck, "diagnose", "w.mcap", "--out", "found", "--quiet")
    found = json.loads((followed / "found/diagnosis.json").read_text())
    assert found["verdict"] == "cause", found["why"]
    (cause,) = found["causes"]
    assert cause["effect"] == "windage"
    truth = json.loads((followed / "w/truth.json").read_text())
    case = {"name": "w", "case": {"manner": "rich", "size": 1.0}, "truth": truth, "diagnosis": found}
    (followed / "case.json").write_text(json.dumps(case))
    score = "from xneck.study.score import score_case; print(json.dumps(score_case(json.load(open('case.json'))).as_json()))"
    scored = json.loads(called(followed, "-c", f"import json; {score}"))
    assert scored["right"]
    (sighting,) = scored["sightings"]
    numbers = {number["index"]: number for number in sighting["numbers"]}
    true = truth["hidden"][0]["parameters"]
    assert {index: number["true"] for index, number in numbers.items()} == {j: true[f"fw{j}"] for j in (1, 2, 3, 4)}
    for number in numbers.values():
        assert abs(number["found"] - number["true"]) < 3 * number["sigma"]
