"""A table of measured figures, as text and as JSON, and what it comes to: ours beside a peer and a limit."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

Named = tuple[str, float | None]
"""what it is called, and its figure"""


@dataclass(frozen=True)
class Claim:
    """A line of the summary. Of all figures less is better: errors, times, shares that are lost."""

    what: str
    """what is measured, and its unit"""
    on: str
    """on which data"""
    ours: float | None
    peer: Named | None = None
    limit: Named | None = None
    """what nobody gets below, or what is needed at any rate"""

    @property
    def ratio(self) -> float | None:
        """Ours over the peer's; over the limit where there is no peer."""
        other = self.peer or self.limit
        if self.ours is None or other is None or not other[1]:
            return None
        return self.ours / other[1]


@dataclass(frozen=True)
class Table:
    """Rows of a label and figures under named columns; the title says what was measured on what."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[float | None, ...]], ...]
    claims: tuple[Claim, ...] = ()
    notes: tuple[str, ...] = ()
    """what the figures say, in sentences"""

    def at(self, row: str, column: str) -> float | None:
        """A figure by its labels."""
        return dict(self.rows)[row][self.columns.index(column)]

    def text(self) -> str:
        """Aligned columns, then the notes."""
        wide = max((len(label) for label, _ in self.rows), default=0) + 2
        widths = [max(len(name), 9) + 2 for name in self.columns]
        lines = [self.title, " " * wide + "".join(f"{n:>{w}}" for n, w in zip(self.columns, widths, strict=True))]
        for label, figures in self.rows:
            cells = (f"{'-' if x is None else format(x, '.4g'):>{w}}" for x, w in zip(figures, widths, strict=True))
            lines.append(f"{label:<{wide}}" + "".join(cells))
        return "\n".join([*lines, *self.notes])

    def as_json(self) -> dict[str, Any]:
        """Title, columns, rows as records, claims with their ratios, notes."""
        return {
            "title": self.title,
            "columns": list(self.columns),
            "rows": [{"what": label} | dict(zip(self.columns, figures, strict=True)) for label, figures in self.rows],
            "claims": [asdict(claim) | {"ratio": claim.ratio} for claim in self.claims],
            "notes": list(self.notes),
        }


def from_json(record: Mapping[str, Any]) -> Table:
    """The table of which `record` is the JSON."""
    columns = tuple(record["columns"])
    return Table(
        record["title"],
        columns,
        tuple((row["what"], tuple(row[name] for name in columns)) for row in record["rows"]),
        tuple(claim_from_json(claim) for claim in record["claims"]),
        tuple(record["notes"]),
    )


def claim_from_json(record: Mapping[str, Any]) -> Claim:
    """The claim of which `record` is the JSON."""
    return Claim(record["what"], record["on"], record["ours"], _named(record["peer"]), _named(record["limit"]))


def _named(pair: list[Any] | None) -> Named | None:
    return None if pair is None else (pair[0], pair[1])
