"""Topics one after the other, each in a process of its own: what dies takes nothing with it, and what is done is kept."""

import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.topic import read_record


@dataclass(frozen=True)
class TopicOutcome:
    """A topic with its record, or with the line that says why there is none."""

    name: str
    record: dict[str, Any] | None
    failure: str | None = None
    measured_before: bool = False
    """whether the record is that of an earlier run"""


def run(topics: Mapping[str, str], folder: Path, again: bool = False) -> Iterator[TopicOutcome]:
    """Each topic (name -> module) as it ends. `again`: also those of which `folder` holds a record that is still true."""
    (folder / "topics").mkdir(parents=True, exist_ok=True)
    for name, module in topics.items():
        record = None if again else read_record(_file(folder, name))
        yield TopicOutcome(name, record, measured_before=True) if record else _measured(name, module, folder)


def still_valid(topics: Mapping[str, str], folder: Path) -> dict[str, TopicOutcome]:
    """Topics of which `folder` holds a record that is still true."""
    records = {name: read_record(_file(folder, name)) for name in topics}
    return {name: TopicOutcome(name, record, measured_before=True) for name, record in records.items() if record}


def _measured(name: str, module: str, folder: Path) -> TopicOutcome:
    file = _file(folder, name).resolve()
    file.unlink(missing_ok=True)
    call = [sys.executable, "-m", "benchmarks.topic", module, str(file)]
    process = subprocess.run(call, stderr=subprocess.PIPE, text=True, errors="replace", cwd=Path(__file__).parents[1])
    record = read_record(file)
    if record:
        return TopicOutcome(name, record)
    sys.stderr.write(process.stderr)
    return TopicOutcome(name, None, _failure(process.returncode, process.stderr))


def _failure(status: int, errors: str) -> str:
    """One line: the last that the process wrote to standard error, unless a signal ended it or it ended well."""
    if status < 0:
        return f"ended by signal {-status}"
    if status == 0:
        return "sources changed while it was measured; run it again"
    return ([f"status {status}"] + [line for line in errors.splitlines() if line.strip()])[-1]


def _file(folder: Path, name: str) -> Path:
    return folder / "topics" / f"{name}.json"
