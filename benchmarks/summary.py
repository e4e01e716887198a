"""All topics' claims as one table: on the terminal, as records, and as rows of the page."""

from collections.abc import Iterable
from typing import Any

from benchmarks.run import TopicOutcome
from benchmarks.table import Claim, Named
from benchmarks.topic import table_of

HEAD = ("what (less is better)", "ours", "peer", "ratio", "limit", "on")
_NONE = "-"


def claims(outcomes: Iterable[TopicOutcome]) -> list[tuple[str, Claim]]:
    """Name of the topic, and claim."""
    return [
        (outcome.name, claim) for outcome in outcomes if outcome.record for claim in table_of(outcome.record).claims
    ]


def as_json(outcomes: Iterable[TopicOutcome]) -> dict[str, Any]:
    """Summary, records of the topics by name, and what failed by name."""
    every = list(outcomes)
    return {
        "summary": [
            {"topic": outcome.name} | claim
            for outcome in every
            if outcome.record
            for claim in outcome.record["table"]["claims"]
        ],
        "failed": {outcome.name: outcome.failure for outcome in every if outcome.failure},
        "topics": {outcome.name: outcome.record for outcome in every if outcome.record},
    }


def text(outcomes: Iterable[TopicOutcome]) -> str:
    """Aligned columns, a row a claim, then a row for each topic that failed."""
    every = list(outcomes)
    rows = [
        (f"{name}: {c.what}", figure(c.ours), named(c.peer), figure(c.ratio), named(c.limit), c.on)
        for name, c in claims(every)
    ]
    widths = [max(map(len, column)) for column in zip(HEAD, *rows, strict=True)]
    lines = ["  ".join(f"{cell:<{w}}" for cell, w in zip(row, widths, strict=True)).rstrip() for row in (HEAD, *rows)]
    return "\n".join([*lines, *(f"{outcome.name}: FAILED, {outcome.failure}" for outcome in every if outcome.failure)])


def figure(value: float | None) -> str:
    """Three significant digits."""
    return _NONE if value is None else format(value, ".3g")


def named(other: Named | None) -> str:
    """The figure, and of what it is."""
    return _NONE if other is None else f"{figure(other[1])} ({other[0]})"
