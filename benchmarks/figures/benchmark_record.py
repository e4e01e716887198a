"""The record of benchmark runs, benchmarks/record/benchmarks.json: each topic's claims, with commit, date and machine."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.table import Claim, claim_from_json
from xneck_foundation.json_text import json_text

RECORD = Path(__file__).parents[1] / "record/benchmarks.json"

Topics = dict[str, dict[str, Any]]
"""by topic: `date`, `commit`, `machine` and `claims`"""


def imported(path: Path, record: Mapping[str, dict[str, Any]]) -> Topics:
    """The record with the topics of a benchmarks.json in place of those of the same name."""
    if path.is_dir():
        path = path / "benchmarks.json"
    measured = json.loads(path.read_text(encoding="utf-8"))["topics"]
    return dict(record) | {
        name: {
            "date": topic["date"],
            "commit": topic["commit"],
            "machine": topic["made_by"]["machine"],
            "claims": topic["table"]["claims"],
        }
        for name, topic in measured.items()
    }


def write_record(topics: Mapping[str, dict[str, Any]], path: Path = RECORD) -> None:
    """Whole or not at all."""
    path.write_text(json_text(topics), encoding="utf-8")


def read_record(path: Path = RECORD) -> Topics:
    """All topics of the record."""
    return json.loads(path.read_text(encoding="utf-8"))


def claims_of(topics: Mapping[str, dict[str, Any]]) -> list[tuple[str, Claim]]:
    """Topic and claim, in the record's order."""
    return [(name, claim_from_json(claim)) for name, topic in topics.items() for claim in topic["claims"]]
