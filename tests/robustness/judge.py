"""Runs something on damaged input and judges how it ended: a result that is whole, or one line that says what is wrong."""

import contextlib
import io
import os
import signal
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any
from unittest import mock

from hypothesis import HealthCheck, Phase, settings

from xneck.cli import main
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import Recovered

TRIED: Counter[str] = Counter()
"""cases by kind, for the session's last line"""
MORE = int(os.environ.get("XNECK_ROBUSTNESS", "1"))
"""times as many cases as in CI"""
MAX_LINE = 500
"""characters of a refusal, the command's name included"""
LIMIT_S = 60
"""no case is let to last longer; a thousand times what a reader takes"""


def some(examples: int, *, shrunk: bool = True) -> settings:
    """So many cases, and times as many where asked for; `shrunk`: with the smallest damage that does it, where cases are quick."""
    phases = [phase for phase in Phase if shrunk or phase not in (Phase.shrink, Phase.explain)]
    return settings(
        max_examples=examples * MORE,
        phases=phases,
        derandomize=MORE == 1,
        deadline=None,
        database=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow, HealthCheck.data_too_large],
    )


class Hangs(BaseException):
    """Not an Exception, so that nothing on the way takes it for one of its own."""


@dataclass(frozen=True)
class Ran:
    """What a command left behind."""

    status: int
    out: str
    err: str


@contextlib.contextmanager
def in_time(seconds: int = LIMIT_S) -> Iterator[None]:
    """Raises Hangs where the block lasts longer."""

    def late(number: int, frame: FrameType | None) -> None:
        raise Hangs(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def read(kind: str, path: Path, reader: Callable[[Path], Any]) -> Any:
    """What `reader` gives, None where it refuses; anything else that it raises, or a refusal that names no file, fails the test."""
    TRIED[kind] += 1
    with in_time(), warnings.catch_warnings():
        warnings.simplefilter("ignore", Recovered)
        try:
            return reader(path)
        except Refused as refusal:
            line = str(refusal)
            assert path.name in line, line
            assert len(line) < MAX_LINE, line
            assert line.isprintable(), line
            return None


def done_or_refused(kind: str, work: Callable[[], Any]) -> Any:
    """What `work` gives, None where it refuses in one line that is not long; anything else that it raises fails the test."""
    TRIED[kind] += 1
    with in_time(), warnings.catch_warnings():
        warnings.simplefilter("ignore", Recovered)
        try:
            return work()
        except Refused as refusal:
            line = str(refusal)
    assert len(line) < 500, line
    return None


def run(kind: str, *words: str | Path) -> Ran:
    """`xneck` with these words, in this process."""
    TRIED[kind] += 1
    out, err = io.StringIO(), io.StringIO()
    status: Any = 0
    with (
        in_time(),
        mock.patch.object(sys, "argv", ["xneck", *map(str, words)]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as ended:
            status = ended.code or 0
    return Ran(int(status), out.getvalue(), err.getvalue())


STAGES = ("sync", "check", "identify", "simulate", "simulation", "model", "design", "diagnose", "calibrate")
"""what a refusal may name instead of a file: where files are well each, but not together"""


def check(ran: Ran, outputs: dict[Path, Callable[[Path], Any]], inputs: tuple[Path, ...]) -> None:
    """Done and every output reads again as whole, or refused in one line that names an input, and no output is there."""
    lines = [line for line in ran.err.splitlines() if not line.startswith("xneck: warning: ")]
    folders = {path.parent for path in outputs}
    if ran.status == 0:
        assert lines == [], ran.err
        with warnings.catch_warnings():
            warnings.simplefilter("error", Recovered)
            for path, reader in outputs.items():
                reader(path)
        left = {p for folder in folders for p in folder.iterdir()} - set(outputs)
    else:
        assert ran.status == 1, ran
        assert ran.out == "", ran.out
        assert len(lines) == 1, ran.err
        assert lines[0].startswith("xneck: "), ran.err
        assert len(lines[0]) < MAX_LINE, ran.err
        assert lines[0].isprintable(), ran.err
        told = lines[0].split(": ")[1]
        assert told in STAGES or any(path.name[-100:] in lines[0] for path in inputs), ran.err
        left = {p for folder in folders for p in folder.iterdir()}
    assert left == set(), left
