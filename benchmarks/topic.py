"""python -m benchmarks.topic MODULE FILE: measures one topic in a process of its own, and writes what it found.

A topic is a module with a function `measure` that returns a Table. Its record holds what it was made by, so that a later run
knows whether it still holds: the sources of the packages and of the generator, the sample, the topic's own modules, the machine.
"""

import importlib
import inspect
import json
import os
import sys
import time
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from benchmarks.machine import commit, machine
from benchmarks.table import Table, from_json
from xneck_foundation.json_text import json_text
from xneck_foundation.provenance import sha256
from xneck_foundation.source_digest import source_digest
from xneck_foundation.whole_file import write_text

SAMPLES = Path(__file__).parents[1] / "samples"


def write_record(module: str, out: Path) -> None:
    """Measures, and writes the record, whole or not at all."""
    began, load, start = datetime.now(UTC), os.getloadavg()[0], time.perf_counter()
    topic = importlib.import_module(module)
    table: Table = topic.measure()
    record = {
        "made_by": _makers() | {"modules": _hashes(_modules(module))},
        "date": began.isoformat(timespec="seconds"),
        "commit": commit(),
        "seconds": time.perf_counter() - start,
        "load": load,
        "words": [inspect.cleandoc(text) for text in (topic.__doc__, topic.measure.__doc__) if text],
        "table": table.as_json(),
    }
    write_text(out, json_text(record))


def read_record(file: Path) -> dict[str, Any] | None:
    """What an earlier run left, or None where there is nothing or something that it was made by is not what it was."""
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
        made_by = dict(record["made_by"])
        modules = made_by.pop("modules")
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return record if made_by == _makers() and modules == _hashes(modules) else None


def table_of(record: Mapping[str, Any]) -> Table:
    """The table that the record holds."""
    return from_json(record["table"])


@cache
def _makers() -> dict[str, Any]:
    sample = {name: sha256(SAMPLES / name) for name in ("recording/video.mp4", "truth.npz")}
    return {"source": source_digest(SAMPLES / "generator"), "sample": sample, "machine": machine()}


def _modules(topic: str) -> list[str]:
    """Modules of the topic's own package that are loaded now."""
    package = topic.split(".")[0]
    return sorted(name for name in sys.modules if name.split(".")[0] == package)


def _hashes(modules: Iterable[str]) -> dict[str, str | None]:
    """SHA-256 of each module's file; None where there is none any more."""
    return {name: _hash(name) for name in modules}


def _hash(module: str) -> str | None:
    try:
        spec = find_spec(module)
    except ModuleNotFoundError:
        return None
    return sha256(spec.origin) if spec and spec.origin else None


if __name__ == "__main__":
    write_record(sys.argv[1], Path(sys.argv[2]))
