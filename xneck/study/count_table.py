"""A table of counts and shares, in plain text, in Markdown and as records."""

import textwrap
from dataclasses import dataclass
from typing import Any

_NOTE_WIDTH = 120
"""characters in a line of the note"""


@dataclass(frozen=True)
class CountTable:
    """Rows of cells, the first column their label; the title says what was counted."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def text(self) -> str:
        """For a terminal: aligned columns, labels to the left."""
        widths = [max(len(row[i]) for row in (self.columns, *self.rows)) for i in range(len(self.columns))]
        lines = [
            "  ".join(f"{c:<{w}}" if i == 0 else f"{c:>{w}}" for i, (c, w) in enumerate(zip(row, widths, strict=True)))
            for row in (self.columns, *self.rows)
        ]
        return "\n".join([self.title, *(line.rstrip() for line in lines), *textwrap.wrap(self.note, _NOTE_WIDTH)])

    def markdown(self) -> str:
        """In Markdown: a heading, the table, and the note."""
        rule = "|".join(["---", *["---:"] * (len(self.columns) - 1)])
        lines = [f"| {' | '.join(row)} |" for row in (self.columns, *self.rows)]
        parts = [f"## {self.title}", "", lines[0], f"|{rule}|", *lines[1:]]
        return "\n".join(parts + (["", self.note] if self.note else []))

    def as_json(self) -> dict[str, Any]:
        """Ready for JSON: the title, and a record for each row."""
        return {"title": self.title, "rows": [dict(zip(self.columns, row, strict=True)) for row in self.rows]}
