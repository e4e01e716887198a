"""A newcomer's first command: a description that is read as it is, asked for on a terminal and nowhere else."""

import json
import os
import pty
import select
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mechanism.description import read_neck
from tests.command import run
from tests.paths import ROOT


def test_what_is_written_is_an_arm(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out, record = tmp_path / "neck.yaml", tmp_path / "init.json"
    ran = run(
        capfd,
        "init",
        "--mechanisms",
        "2",
        "--cables",
        "6",
        "--L",
        "0.09",
        "--b",
        "0.04",
        "--out",
        out,
        "--json",
        record,
    )
    assert (ran.status, ran.err) == (0, "")
    neck = read_neck(out)
    assert (neck.N, neck.M, neck.mechanisms[0].L, neck.mechanisms[1].b) == (2, 6, 0.09, 0.04)
    said = json.loads(record.read_text())
    assert [tuple(route) for route in said["routes"]] == [cable.route for cable in neck.cables]
    assert f"xneck show {out} --out {out.with_suffix('.svg')}" in ran.out


def test_nothing_is_asked_off_a_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = run(capfd, "init", "--out", tmp_path / "neck.yaml")
    assert ran.status == 0
    assert "?" not in ran.out
    neck = read_neck(tmp_path / "neck.yaml")
    assert (neck.N, neck.M) == (3, 4)


def test_on_a_terminal_what_is_missing_is_asked(tmp_path: Path) -> None:
    """`--mechanisms` is given, so that cables, L and b are asked, in this order; an empty answer takes what is usual."""
    master, slave = pty.openpty()
    words = [sys.executable, "-m", "xneck", "init", "--mechanisms", "2"]
    process = subprocess.Popen(
        [*words, "--out", str(tmp_path / "neck.yaml")], cwd=ROOT, stdin=slave, stdout=slave, stderr=slave
    )
    os.close(slave)
    shown = ""
    for question, answer in (("cables", "many\n5\n"), ("Length L", "0.08\n"), ("Length b", "\n")):
        shown += wait_for(master, question)
        os.write(master, answer.encode())
    shown += wait_for(master, "xneck show")
    process.wait(timeout=60)
    os.close(master)
    assert "mechanisms (X-joints)" not in shown
    assert "'many' is not a valid integer" in shown
    neck = read_neck(tmp_path / "neck.yaml")
    assert (neck.N, neck.M, neck.mechanisms[0].L, neck.mechanisms[0].b) == (2, 5, 0.08, 0.04)


def wait_for(terminal: int, words: str) -> str:
    """What a program writes to a terminal until these words are in it."""
    shown, end = "", time.monotonic() + 60
    while words not in shown and time.monotonic() < end:
        if select.select([terminal], [], [], 1.0)[0]:
            shown += os.read(terminal, 4096).decode()
    assert words in shown, shown
    return shown


def test_what_was_filled_in_is_not_lost(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "neck.yaml"
    assert run(capfd, "init", "--out", out).status == 0
    assert run(capfd, "init", "--out", out).status == 0  # nobody has touched it
    out.write_text(out.read_text().replace("L: 0.1", "L: 0.11"))
    refused = run(capfd, "init", "--out", out)
    assert refused.status == 1
    assert "--force" in refused.err
    assert "L: 0.11" in out.read_text()


@pytest.mark.parametrize(
    ("mechanisms", "cables", "says"),
    [(3, 2, "2 cables cannot be tensioned against 3 joints"), (2, 1, "1 cable cannot be tensioned against 2 joints")],
)
def test_an_arm_with_too_few_cables_is_written_with_a_warning(
    mechanisms: int, cables: int, says: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "neck.yaml"
    ran = run(capfd, "init", "--mechanisms", str(mechanisms), "--cables", str(cables), "--out", out)
    assert (ran.status, ran.err) == (0, f"xneck: warning: {out}: {says}; it takes more cables\n")
    assert cables == read_neck(out).M


def test_lengths_that_make_no_x_joint_are_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = run(capfd, "init", "--L", "0.05", "--b", "0.06", "--out", tmp_path / "neck.yaml")
    assert ran == (
        1,
        "",
        "xneck: init: L = 0.05 m must exceed b = 0.06 m for the diagonals to cross; give other --L and --b\n",
    )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["neck", "board", "recording"])
def test_a_schema_is_a_file_of_its_own(kind: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    schema = tmp_path / f"{kind}.schema.json"
    ran = run(capfd, "init", "--schema", schema, "--schema-of", kind)
    assert ran.status == 0
    assert f"$schema={schema.name}" in ran.out
    assert json.loads(schema.read_text())["title"] == f"{kind}.yaml"


def test_the_description_names_its_schema(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "schemas").mkdir()
    schema, out = tmp_path / "schemas/neck.json", tmp_path / "neck.yaml"
    assert run(capfd, "init", "--out", out, "--schema", schema).status == 0
    assert out.read_text().splitlines()[0] == "# yaml-language-server: $schema=schemas/neck.json"
    assert read_neck(out).N == 3


def test_nothing_to_write_is_wrong_usage(capfd: pytest.CaptureFixture[str]) -> None:
    ran = run(capfd, "init")
    assert ran.status == 2
    assert "--out neck.yaml" in ran.err
