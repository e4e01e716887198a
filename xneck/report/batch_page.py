"""A batch as one HTML page: all recordings in a table with links to their reports, and their parameters side by side."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

from markupsafe import Markup

from xneck.report.batch_rows import HEAD, MAIN, cells, sentence
from xneck.report.template import render
from xneck.report.wording import with_sigma
from xneck_foundation.whole_file import write_text

Rows = Mapping[str, Mapping[str, Any]]


def write_batch_report(
    rows: Rows, versions: Mapping[str, Any], path: Path, diagnosis: Mapping[str, Any] | None = None
) -> None:
    """The page, whole or not at all, for `rows` of batch_rows by recording, and the `diagnosis` of them where there is one."""
    write_text(path, page(rows, versions, diagnosis))


def page(rows: Rows, versions: Mapping[str, Any], diagnosis: Mapping[str, Any] | None) -> str:
    """The HTML of a batch."""
    return render(
        "batch.html.jinja",
        sentence=sentence(rows.values()),
        failed={name: row["failure"] for name, row in rows.items() if row["failure"] is not None},
        lossy={name: row["recovered"] for name, row in rows.items() if row.get("recovered")},
        diagnosis=diagnosis,
        head=HEAD,
        rows=[(_link(name, row), *cells(name, row)[1:]) for name, row in rows.items()],
        parameters=parameter_tables(rows),
        versions=f"xneck {versions['xneck']}, Python {versions['python']}",
    )


def _link(name: str, row: Mapping[str, Any]) -> str | Markup:
    if row["failure"] is not None:
        return name
    # ./ keeps a name like `mail:me` from being taken for an address
    return Markup('<a href="./{}">{}</a>').format(quote(row["report"]), name)


def parameter_tables(rows: Rows) -> list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]]:
    """Of each main parameter its title, its columns and a row for each recording that was fitted."""
    out = []
    for symbol, words in MAIN.items():
        found = {
            name: {p["index"]: p for p in row["parameters"] if p["name"] == symbol}
            for name, row in rows.items()
            if row["failure"] is None
        }
        indices = sorted({index for own in found.values() for index in own})
        if not indices:
            continue
        unit = next(p["unit"] for own in found.values() for p in own.values())
        body = [(name, *(_value(own.get(index)) for index in indices)) for name, own in found.items()]
        out.append((f"{words.capitalize()} {symbol}, {unit}", ("recording", *(f"cable {i}" for i in indices)), body))
    return out


def _value(p: Mapping[str, Any] | None) -> str:
    if p is None:
        return "–"
    if not p["identified"]:
        return "not identified"
    return with_sigma(p["value"], p["sigma"])
