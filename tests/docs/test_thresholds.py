"""docs/thresholds.md names every number that decides a verdict, with the value that it has, and the code names the page."""

import ast
import re
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import pairwise
from math import radians
from pathlib import Path
from pkgutil import resolve_name

import pytest

from benchmarks.thresholds.record import read_record
from benchmarks.tuned_seeds import TUNED_SEEDS, TUNED_WORLDS
from mechanism.tolerance import Tolerance
from tests.docs.pages import PAGES

ROOT = Path(__file__).parents[2]
ROOMS = (
    "calibration", "diagnosis", "discovery", "identification", "mechanism", "observation", "state_estimation", "synchronisation",
    "vision", "xneck", "xneck_foundation",
)  # fmt: skip
TAG = "(docs/thresholds.md)"
"""ends the docstring of a constant that decides"""
ROW = re.compile(r"^\| `([\w.]+)` \| ([^|]*) \|", re.MULTILINE)
NUMBERS = re.compile(r"-?(?:[\d.]+(?:e[-+]?\d+)?|inf)(?:, -?(?:[\d.]+(?:e[-+]?\d+)?|inf))*")
"""what a value begins with; its unit follows"""
PAGE = PAGES["thresholds.md"]
VALUES = dict(ROW.findall(PAGE))


def tagged(text: str) -> set[str]:
    """Constants of a module, and of its classes, whose docstring ends in the tag."""
    return set(_tagged(ast.parse(text).body))


def _tagged(body: Sequence[ast.stmt]) -> Iterator[str]:
    for node, after in pairwise([*body, ast.Pass()]):
        if isinstance(node, ast.ClassDef):
            yield from (f"{node.name}.{name}" for name in _tagged(node.body))
        if not isinstance(node, ast.Assign | ast.AnnAssign) or not isinstance(after, ast.Expr):
            continue
        if not (isinstance(after.value, ast.Constant) and str(after.value.value).endswith(TAG)):
            continue
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        for target in targets:
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            yield from (name.id for name in names if isinstance(name, ast.Name))


@cache
def every_tagged() -> frozenset[str]:
    files = [file for room in ROOMS for file in (ROOT / room).rglob("*.py")]
    return frozenset(
        f"{'.'.join(file.relative_to(ROOT).with_suffix('').parts)}.{name}"
        for file in files
        for name in tagged(file.read_text(encoding="utf-8"))
    )


def test_a_constant_stands_on_the_page_once() -> None:
    labels = [label for label, _ in ROW.findall(PAGE)]
    assert labels
    assert [label for label in set(labels) if labels.count(label) > 2] == []


@pytest.mark.parametrize("label", sorted(VALUES))
def test_a_constant_of_the_page_has_the_value_that_it_says(label: str) -> None:
    value = resolve_name(label)
    said = VALUES[label].strip()
    if said == "several":
        assert not isinstance(value, int | float)
        return
    numbers = value if isinstance(value, tuple) else (value,)
    found = NUMBERS.match(said)
    assert found is not None
    assert [float(each) for each in found[0].split(",")] == pytest.approx([float(n) for n in numbers], rel=1e-5)


def test_the_page_and_the_code_name_each_other() -> None:
    """A constant that decides ends its docstring in the page's name; the page has a row for it, and for no other."""
    assert sorted(every_tagged() - set(VALUES)) == []
    assert sorted(set(VALUES) - every_tagged()) == []


def test_tolerances_are_those_of_the_page_on_recordings() -> None:
    rows = re.findall(r"^\| (\w+) \| [^|]* \| ([\d.]+) \| (of itself|deg) \|$", PAGES["recording.md"], re.MULTILINE)
    said = {key: radians(float(value)) if unit == "deg" else float(value) for key, value, unit in rows}
    assert said == pytest.approx(Tolerance().model_dump())


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (f'A = 1\n"""of something {TAG}"""\nB = 2\n"""of something"""\n', {"A"}),
        (f'A, B = 1, 2\n"""{TAG}"""\n', {"A", "B"}),
        (f'A: float = 1\n"""{TAG}"""\n', {"A"}),
        (f'f(1)\n"""{TAG}"""\n', set()),
        (f'class C:\n    A = 1\n    """{TAG}"""\n    B = 2\n', {"C.A"}),
    ],
)
def test_a_tag_is_noticed(text: str, names: set[str]) -> None:
    assert tagged(text) == names


def test_what_was_measured_stands_on_the_page() -> None:
    named = set(re.findall(r"<!--figure thresholds\.([a-z0-9_.]+)-->", PAGE))
    measured = {
        f"{room}.{label.lower()}.{which}"
        for room, found in read_record().items()
        for label, tried in found["thresholds"].items()
        for which in tried
    }
    assert sorted(measured - named) == []


def test_nothing_was_set_on_the_worlds_of_the_page() -> None:
    """Names of worlds begin with their seed, where they have one."""
    record = read_record()
    for rooms, seeds in (
        (("diagnosis", "diagnosis_fits", "signature"), TUNED_SEEDS),
        (("check", "clocks"), TUNED_WORLDS),
    ):
        for room in set(rooms) & set(record):
            worlds = {
                w for tried in record[room]["thresholds"].values() for each in tried.values() for w in each["changed"]
            }
            worlds |= set(record[room]["not_right"])
            used = {int(found[0]) for world in worlds if (found := re.match(r"\d{2,}(?= )", world))}
            assert not used & set(seeds)
