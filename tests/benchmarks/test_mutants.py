"""What a mutation test counts, and which tests it runs."""

from pathlib import Path

import pytest

from benchmarks import mutants
from benchmarks.mutants import Score, Survivor, as_markdown

SEEN = Survivor("mechanism.geometry.span", "a + b", "a - b", called=True)
ALIKE = Survivor("mechanism.geometry.span", "x * 1", "x / 1", called=True)
UNCALLED = Survivor("mechanism.laws.Law.pull", "x", "None", called=False)


def test_equivalent_mutants_are_named_and_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mutants, "EQUIVALENT", {(ALIKE.function, ALIKE.after): "one divides as it multiplies"})
    score = Score("mechanism", 800, 50, (SEEN, ALIKE, UNCALLED))
    assert score.rate.text == "47 of 49"
    page = as_markdown([score])
    assert "| `mechanism` | 800 | 50, 1 equivalent | 47 of 49 | 95.9 % | 86 to 99.5 % |" in page
    assert "- `mechanism.geometry.span`: `a + b` -> `a - b`\n" in page
    assert "`x / 1` (one divides as it multiplies)" in page
    assert "`None` (no test calls it)" in page


def test_tests_of_a_part_are_those_that_mirror_it_or_the_whole(tmp_path: Path) -> None:
    assert mutants._tests_of("identification/dataset") == "tests/identification/dataset"
    assert mutants._tests_of("mechanism/laws") == "tests/mechanism"
    for name in ("test_laws.py", "test_simulation.py", "paths.py"):
        (tmp_path / "tests/mechanism").mkdir(parents=True, exist_ok=True)
        (tmp_path / "tests/mechanism" / name).touch()
    # test_simulation.py is named slow
    assert mutants._fast_tests(tmp_path / "tests/mechanism", tmp_path) == ["tests/mechanism/test_laws.py"]
