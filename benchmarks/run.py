"""Topics one after the other, each in a process of its own: what dies takes nothing with it, and what is done is kept."""

import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.topic import read_record


@dataclass(frozen=True)
class Ended:
    """A topic with its record, or with the line that says why there is none."""

    name: str
    record: dict[str, Any] | None
    failure: str | None = None
    before: bool = False
    """whether the record is that of an earlier run"""


def run(topics: Mapping[str, str], folder: Path, again: bool = False) -> Iterator[Ended]:
    """Each topic (name -> module) as it ends. `again`: also those of which `folder` holds a record that is still true."""
    (folder / "topics").mkdir(parents=True, exist_ok=True)
    for name, module in topics.items():
        kept = None if again else read_record(_file(folder, name))
        yield Ended(name, kept, before=True) if kept else _measured(name, module, folder)


def kept(topics: Mapping[str, str], folder: Path) -> dict[str, Ended]:
    """Topics of which `folder` holds a record that is still true."""
    found = {name: read_record(_file(folder, name)) for name in topics}
    return {name: Ended(name, record, before=True) for name, record in found.items() if record}


def _measured(name: str, module: str, folder: Path) -> Ended:
    file = _file(folder, name).resolve()
    file.unlink(missing_ok=True)
    call = [sys.executable, "-m", "benchmarks.topic", module, str(file)]
    done = subprocess.run(call, stderr=subprocess.PIPE, text=True, errors="replace", cwd=Path(__file__).parents[1])
    record = read_record(file)
    if record:
        return Ended(name, record)
    sys.stderr.write(done.stderr)
    return Ended(name, None, _why(done.returncode, done.stderr))


def _why(status: int, said: str) -> str:
    """A line: the last that the process said, unless it was cut short or said nothing was wrong."""
    if status < 0:
        return f"ended by signal {-status}"
    if status == 0:
        return "sources changed while it was measured; run it again"
    return ([f"status {status}"] + [line for line in said.splitlines() if line.strip()])[-1]


def _file(folder: Path, name: str) -> Path:
    return folder / "topics" / f"{name}.json"
