"""The README's commands exist as it says, and its Python runs."""

import re
from pathlib import Path

import click
import pytest

from vision.cli import COMMANDS, group

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "README.md").read_text()


def shown() -> list[str]:
    return re.findall(r"^ +(xneck [a-z]+ .+)$", TEXT, flags=re.MULTILINE)


def test_it_shows_the_main_commands() -> None:
    assert {line.split()[1] for line in shown()} >= {
        "board",
        "calibrate",
        "extract",
        "sync",
        "check",
        "identify",
        "run",
    }
    assert set(re.findall(r"`?xneck ([a-z]+)", TEXT)) - {"in", "reads"} <= set(COMMANDS)


@pytest.mark.parametrize("line", shown())
def test_every_command_parses(line: str) -> None:
    """Names of commands and options are right; the files of the example are not there."""
    _, name, *words = line.split("#")[0].split()
    command = group.get_command(click.Context(group), name)
    assert command is not None
    command.make_context(name, words, resilient_parsing=False)


def test_make_targets_are_there() -> None:
    makefile = (ROOT / "Makefile").read_text()
    for target in re.findall(r"`?make ([a-z]+)", TEXT):
        if target != "and":
            assert f"\n{target}:" in makefile
