"""All topics' claims as one table: on the terminal, as records, and as rows of the page."""

from collections.abc import Iterable
from typing import Any

from benchmarks.run import Ended
from benchmarks.table import Claim, Named
from benchmarks.topic import table_of

HEAD = ("what (less is better)", "ours", "peer", "ratio", "limit", "on")
_NONE = "-"


def claims(ended: Iterable[Ended]) -> list[tuple[str, Claim]]:
    """Name of the topic, and claim."""
    return [(one.name, claim) for one in ended if one.record for claim in table_of(one.record).claims]


def as_json(ended: Iterable[Ended]) -> dict[str, Any]:
    """Summary, records of the topics by name, and what failed by name."""
    every = list(ended)
    return {
        "summary": [
            {"topic": one.name} | claim for one in every if one.record for claim in one.record["table"]["claims"]
        ],
        "failed": {one.name: one.failure for one in every if one.failure},
        "topics": {one.name: one.record for one in every if one.record},
    }


def text(ended: Iterable[Ended]) -> str:
    """Aligned columns, a row a claim, then a row for each topic that failed."""
    every = list(ended)
    rows = [
        (f"{name}: {c.what}", figure(c.ours), named(c.peer), figure(c.ratio), named(c.limit), c.on)
        for name, c in claims(every)
    ]
    widths = [max(map(len, column)) for column in zip(HEAD, *rows, strict=True)]
    lines = ["  ".join(f"{cell:<{w}}" for cell, w in zip(row, widths, strict=True)).rstrip() for row in (HEAD, *rows)]
    return "\n".join([*lines, *(f"{one.name}: FAILED, {one.failure}" for one in every if one.failure)])


def figure(value: float | None) -> str:
    """Three significant digits."""
    return _NONE if value is None else format(value, ".3g")


def named(other: Named | None) -> str:
    """The figure, and of what it is."""
    return _NONE if other is None else f"{figure(other[1])} ({other[0]})"
