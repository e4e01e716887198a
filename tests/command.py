"""Runs the command line in this process as a shell would."""

import sys
from pathlib import Path
from typing import NamedTuple
from unittest import mock

import pytest

from xneck.cli import main


class Ran(NamedTuple):
    """What a command left behind."""

    status: int
    out: str
    err: str


def run(capfd: pytest.CaptureFixture[str], *words: str | Path) -> Ran:
    """`xneck` with these words."""
    capfd.readouterr()
    with mock.patch.object(sys, "argv", ["xneck", *map(str, words)]), pytest.raises(SystemExit) as caught:
        main()
    out, err = capfd.readouterr()
    code = caught.value.code
    return Ran(code if isinstance(code, int) else 0, out, err)
