"""One command, one table: what it keeps, what it says of a topic that fails, and its page. The topics here measure nothing."""

import importlib
import inspect
import json
import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from playwright.sync_api import Page

import benchmarks.__main__ as command
from benchmarks.__main__ import TOPICS, main
from benchmarks.table import Claim, Table, from_json
from tests.html_page import Elements, check_alone, look
from xneck_foundation.json_text import json_text

NASTY = "<b>bold</b> & more"
QUICK = f'''"""Nothing, quickly: {NASTY}

In two paragraphs.
"""
from pathlib import Path

from benchmarks.table import Claim, Table


def measure():
    """Measures how often it was asked."""
    count = Path(__file__).with_suffix(".count")
    count.write_text(count.read_text() + "x" if count.exists() else "x")
    rows = (("ours", (0.25, None)), ("theirs", (1.0, 3.0)))
    claims = (Claim("time of nothing, s", "{NASTY}", 0.25, ("theirs", 1.0), ("a limit", 0.125)),)
    return Table("Quick table", ("s", "lost"), rows, claims, ("A note of it.",))
'''
LIMITED = '''"""Beside a limit only."""
from benchmarks.table import Claim, Table


def measure():
    return Table("Limited table", ("z",), (("ours", (3.0,)),), (Claim("z", "numbers", 3.0, limit=("one", 1.5)),))
'''
BROKEN = '''"""Does not end well."""


def measure():
    raise ValueError("no such luck")
'''
KILLED = '''"""Ends at once."""
import os
import signal


def measure():
    os.kill(os.getpid(), signal.SIGKILL)
'''
GOOD = {"quick": "quick_topic", "limited": "limited_topic"}
ALL = GOOD | {"broken": "broken_topic", "killed": "killed_topic"}


@pytest.fixture(scope="module")
def modules(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of the topics, on the path of this process and of those that it starts."""
    folder = tmp_path_factory.mktemp("modules")
    for name, text in zip(ALL.values(), (QUICK, LIMITED, BROKEN, KILLED), strict=True):
        (folder / f"{name}.py").write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        patch.setenv("PYTHONPATH", os.pathsep.join(path for path in sys.path if path))
        yield folder


@pytest.fixture(scope="module")
def made(modules: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, int]:
    """A folder with everything run once, and the exit status."""
    out = tmp_path_factory.mktemp("out") / "deeper"
    return out, main(["--out", str(out)], ALL)


def counted(modules: Path) -> int:
    return len((modules / "quick_topic.count").read_text())


def summary_of(out: Path) -> Mapping[str, Mapping[str, object]]:
    return {line["what"]: line for line in json.loads((out / "benchmarks.json").read_text())["summary"]}


def test_a_table_comes_back_from_json() -> None:
    claims = (Claim("a", "b", 1.5, ("peer", 3.0)), Claim("c", "d", None), Claim("e", "f", 2.0, limit=("least", 1.0)))
    table = Table("Title", ("x", "y"), (("row", (1.0, None)), ("row", (2.5, -3e-9))), claims, ("Words.",))
    assert from_json(json.loads(json_text(table.as_json()))) == table
    empty = Table("Skipped", ("x",), ())
    assert from_json(json.loads(json_text(empty.as_json()))) == empty
    assert [claim.ratio for claim in claims] == [0.5, None, 2.0]


def test_topics_that_fail_are_named_and_the_others_go_on(made: tuple[Path, int]) -> None:
    out, status = made
    assert status == 1
    record = json.loads((out / "benchmarks.json").read_text())
    assert list(record["topics"]) == ["quick", "limited"]
    assert record["failed"] == {"broken": "ValueError: no such luck", "killed": "ended by signal 9"}
    assert record["not_run"] == []
    assert {line["what"]: line["ratio"] for line in record["summary"]} == {"time of nothing, s": 0.25, "z": 2.0}
    assert record["command"] == f"python -m benchmarks --out {out}"


def test_what_is_done_is_not_done_again(modules: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--out", str(tmp_path)]
    assert main(words, GOOD) == 0
    before = counted(modules)
    assert main(words, GOOD) == 0
    assert counted(modules) == before
    assert capsys.readouterr().out.count("measured before") == 2
    assert main([*words, "--again", "quick"], GOOD) == 0
    assert counted(modules) == before + 1
    source = modules / "quick_topic.py"
    source.write_text(QUICK + "\n\nCHANGED = True\n")
    assert main([*words, "limited"], GOOD) == 0
    assert list(json.loads((tmp_path / "benchmarks.json").read_text())["topics"]) == ["limited"], "no longer true"
    source.write_text(QUICK)
    assert main([*words, "limited"], GOOD) == 0
    assert list(summary_of(tmp_path)) == ["time of nothing, s", "z"], "true again, and shown though not asked for"
    assert counted(modules) == before + 1
    record = json.loads((tmp_path / "topics/quick.json").read_text())
    for key in ("source", "sample", "machine"):
        changed = json.loads(json.dumps(record))
        changed["made_by"][key] = "another"
        (tmp_path / "topics/quick.json").write_text(json.dumps(changed))
        main(words, GOOD)
        before += 1
        assert counted(modules) == before + 1, key


def test_an_interruption_leaves_a_page_of_what_is_done(
    modules: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = command.run

    def interrupted(*given: object) -> Iterator[object]:
        yield next(whole(*given))  # type: ignore[arg-type]
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "run", interrupted)
    assert main(["--out", str(tmp_path)], GOOD) == 130
    assert "interrupted" in capsys.readouterr().err
    assert list(summary_of(tmp_path)) == ["time of nothing, s"]
    assert "not run: limited" in (tmp_path / "benchmarks.html").read_text()
    monkeypatch.undo()


def test_the_page_says_what_benchmarks_json_says(made: tuple[Path, int]) -> None:
    out, _ = made
    text = (out / "benchmarks.html").read_text(encoding="utf-8")
    elements = Elements(text)
    check_alone(out / "benchmarks.html", elements)
    assert NASTY not in text
    assert "NaN" not in text
    shown = " ".join(elements.text.split())
    record = json.loads((out / "benchmarks.json").read_text())
    for said in (NASTY, "A note of it.", "In two paragraphs.", "Measures how often it was asked.", record["command"]):
        assert said in shown
    for said in record["failed"].values():
        assert said in shown
    machine = record["topics"]["quick"]["made_by"]["machine"]
    for said in (machine["processor"], machine["python"], *machine["libraries"].values()):
        assert said in shown
    assert record["topics"]["quick"]["date"] in shown
    assert (record["topics"]["quick"]["commit"] or "not known") in shown
    cells = ("time of nothing, s", "0.2500", "1.000", "theirs", "0.2500", "0.1250", "a limit", NASTY)
    assert "".join(cells) in shown


@pytest.mark.parametrize("width", [390, 1280])
def test_a_browser_shows_it(browser_page: Page, made: tuple[Path, int], width: int) -> None:
    look(browser_page, made[0] / "benchmarks.html", width)


def test_an_unknown_name_is_wrong_usage(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["nothing", "--out", str(tmp_path)])


def test_every_topic_can_be_measured() -> None:
    """Its module has a function of that name which needs to be told nothing, and both say what they do."""
    for name, module in ((name, importlib.import_module(path)) for name, path in TOPICS.items()):
        asked = inspect.signature(module.measure).parameters.values()
        assert all(p.default is not p.empty for p in asked), name
        assert module.__doc__
        assert module.measure.__doc__
