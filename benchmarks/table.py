"""A table of measured figures, as text and as JSON."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Table:
    """Rows of a label and figures under named columns; the title says what was measured on what."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[float | None, ...]], ...]

    def text(self) -> str:
        """Aligned columns."""
        wide = max((len(label) for label, _ in self.rows), default=0) + 2
        widths = [max(len(name), 9) + 2 for name in self.columns]
        lines = [self.title, " " * wide + "".join(f"{n:>{w}}" for n, w in zip(self.columns, widths, strict=True))]
        for label, figures in self.rows:
            cells = (f"{'-' if x is None else format(x, '.4g'):>{w}}" for x, w in zip(figures, widths, strict=True))
            lines.append(f"{label:<{wide}}" + "".join(cells))
        return "\n".join(lines)

    def as_json(self) -> dict[str, Any]:
        """Title and rows as records."""
        records = [{"what": label} | dict(zip(self.columns, figures, strict=True)) for label, figures in self.rows]
        return {"title": self.title, "rows": records}
