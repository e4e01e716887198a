"""The record of what was measured, benchmarks/record/thresholds.json: counts by room and threshold."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from benchmarks.thresholds.run import Line
from xneck_foundation.json_text import json_text

RECORD = Path(__file__).parents[1] / "record/thresholds.json"

Record = dict[str, dict[str, Any]]
"""by room: `worlds`, `right`, `false` as things are, and by threshold what half and twice make of them"""


def counted(lines: Iterable[Line]) -> dict[str, Any]:
    """Of one room. Each threshold's counts stand beside those of the same worlds as things are."""
    every = list(lines)
    base = {line["world"]: line for line in every if line["threshold"] is None}
    by_threshold: dict[str, dict[str, Any]] = {}
    tried: dict[tuple[str, str], list[Line]] = {}
    for line in every:
        if line["threshold"] is not None and line["world"] in base:
            tried.setdefault((line["threshold"], line["which"]), []).append(line)
    for (label, which), group in tried.items():
        before = [base[line["world"]] for line in group]
        changed = [
            line["world"]
            for line, was in zip(group, before, strict=True)
            if (line["right"], line["false"]) != (was["right"], was["false"])
        ]
        by_threshold.setdefault(label, {})[which] = {
            "value": group[0]["value"],
            "worlds": len(group),
            "right": [_count(before, "right"), _count(group, "right")],
            "false": [_count(before, "false"), _count(group, "false")],
            "changed": changed,
        }
    return {
        "worlds": len(base),
        "right": _count(base.values(), "right"),
        "false": _count(base.values(), "false"),
        "not_right": sorted(world for world, line in base.items() if not line["right"]),
        "thresholds": by_threshold,
    }


def write_record(record: Mapping[str, Any], path: Path = RECORD) -> None:
    """Whole or not at all."""
    path.write_text(json_text(record), encoding="utf-8")


def read_record(path: Path = RECORD) -> Record:
    """All rooms."""
    return json.loads(path.read_text(encoding="utf-8"))


def _count(lines: Iterable[Line], what: str) -> int:
    return sum(bool(line[what]) for line in lines)
