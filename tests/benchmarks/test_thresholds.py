"""Thresholds are tried everywhere where they are imported, and a run that was stopped goes on."""

import ast
import json
import sys
import types
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from benchmarks.figures.threshold_figures import threshold_figures
from benchmarks.thresholds.__main__ import ROOMS
from benchmarks.thresholds.outcome import Outcome
from benchmarks.thresholds.patching import patched
from benchmarks.thresholds.record import counted
from benchmarks.thresholds.room import Room
from benchmarks.thresholds.run import read_lines, run
from benchmarks.thresholds.threshold import Threshold, scaled

LIMIT = 3.0
COUNT = 3
SIGMAS = (1.0, 2.0)
BY_NAME = {"a": (1.0, 4.0)}


class World:
    def __init__(self, name: str, size: float) -> None:
        self.name, self.size = name, size


WORLDS = [World("small", 1.0), World("middle", 2.0), World("large", 5.0)]


def judged(world: World) -> Outcome:
    """Large ones are over the limit, and so is nothing else."""
    over = world.size > LIMIT
    return Outcome(over == (world.name == "large"), over and world.name != "large", "over" if over else "below")


def room(worlds: Sequence[World] = WORLDS) -> Room:
    return Room("sizes", lambda folder: worlds, judged, lambda: scaled(__name__, "LIMIT"))


def test_a_patch_reaches_modules_that_import_the_constant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "holds_limit.py").write_text("LIMIT = 1.0\n")
    (tmp_path / "uses_limit.py").write_text("from holds_limit import LIMIT as OWN\n\n\ndef own():\n    return OWN\n")
    monkeypatch.syspath_prepend(tmp_path)
    import uses_limit  # pyright: ignore[reportMissingImports]

    assert isinstance(uses_limit, types.ModuleType)
    with patched("holds_limit", "LIMIT", 2.0):
        assert uses_limit.own() == 2.0
    assert uses_limit.own() == 1.0
    for name in ("holds_limit", "uses_limit"):
        sys.modules.pop(name)


def test_half_and_twice_of_numbers_counts_tuples_and_mappings() -> None:
    tried = [t.tried for t in scaled(__name__, "LIMIT", "COUNT", "SIGMAS", "BY_NAME")]
    assert tried == [
        (("half", 1.5), ("twice", 6.0)),
        (("half", 1), ("twice", 6)),
        (("half", (0.5, 1.0)), ("twice", (2.0, 4.0))),
        (("half", {"a": (0.5, 2.0)}), ("twice", {"a": (2.0, 8.0)})),
    ]


def test_verdicts_are_counted_beside_those_of_the_same_worlds(tmp_path: Path) -> None:
    """At half the middle one is called over the limit, at twice the large one is not."""
    list(run(room(), tmp_path))
    record = counted(read_lines(tmp_path / "sizes.jsonl"))
    assert (record["worlds"], record["right"], record["false"]) == (3, 3, 0)
    tried = record["thresholds"][f"{__name__}.LIMIT"]
    assert tried["half"] == {"value": "1.5", "worlds": 3, "right": [3, 2], "false": [0, 1], "changed": ["middle"]}
    assert tried["twice"] == {"value": "6", "worlds": 3, "right": [3, 2], "false": [0, 0], "changed": ["large"]}
    figures = threshold_figures({"sizes": record})
    assert figures[f"thresholds.sizes.{__name__.lower()}.limit.half"] == "3/3 -> 2/3, false 0 -> 1"
    assert figures["thresholds.sizes"] == "3 of 3 right, 0 false"


def test_a_run_that_was_stopped_goes_on(tmp_path: Path) -> None:
    list(run(room(WORLDS[:2]), tmp_path))
    file = tmp_path / "sizes.jsonl"
    file.write_text(file.read_text() + '{"threshold": nu')  # a line that was cut off
    lines = list(run(room(), tmp_path))
    assert {line["world"] for line in lines} == {"large"}
    assert len(file.read_text().splitlines()) == 9
    assert all(json.loads(line) for line in file.read_text().splitlines())
    assert list(run(room(), tmp_path)) == []


def test_a_threshold_has_its_value_again() -> None:
    (limit,) = scaled(__name__, "LIMIT")
    assert isinstance(limit, Threshold)
    with pytest.raises(ZeroDivisionError), patched(limit.module, limit.name, limit.half):
        _ = LIMIT / 0
    assert LIMIT == 3.0


def bound_early(module: str, text: str) -> Iterator[str]:
    """Labels of constants that a module binds where it makes a function: as the default of an argument."""
    tree = ast.parse(text)
    imported = {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef | ast.Lambda):
            for default in (*function.args.defaults, *filter(None, function.args.kw_defaults)):
                for node in ast.walk(default):
                    if isinstance(node, ast.Name):
                        yield imported.get(node.id, f"{module}.{node.id}")


def test_a_default_of_an_argument_is_noticed() -> None:
    text = "from a.b import LIMIT\nOWN = 1\n\n\ndef f(x=LIMIT, *, y=OWN):\n    return x + LIMIT\n"
    assert list(bound_early("c", text)) == ["a.b.LIMIT", "c.OWN"]


def test_no_threshold_is_tried_whose_value_was_bound_before() -> None:
    tried = {threshold.label for each in ROOMS.values() for threshold in each.thresholds()}
    root = Path(__file__).parents[2]
    files = [file for label in {label.split(".")[0] for label in tried} for file in (root / label).rglob("*.py")]
    assert files
    early = {
        label
        for file in files
        for label in bound_early(
            ".".join(file.relative_to(root).with_suffix("").parts), file.read_text(encoding="utf-8")
        )
    }
    assert sorted(tried & early) == []
