"""A batch as one HTML page: all recordings in a table with links to their reports, and their parameters side by side."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

from markupsafe import Markup

from xneck.report.batch_table import COLUMNS, MAIN_PARAMETERS, batch_sentence, row_cells
from xneck.report.number_text import with_sigma
from xneck.report.template import render
from xneck_foundation.whole_file import write_text

Rows = Mapping[str, Mapping[str, Any]]


def write_batch_report(
    rows: Rows, versions: Mapping[str, Any], path: Path, diagnosis: Mapping[str, Any] | None = None
) -> None:
    """The page, whole or not at all, for the summary's `rows` by recording, and the summary's `diagnosis` where there is one."""
    write_text(path, batch_html(rows, versions, diagnosis))


def batch_html(rows: Rows, versions: Mapping[str, Any], diagnosis: Mapping[str, Any] | None) -> str:
    """The HTML of a batch's page."""
    return render(
        "batch.html.jinja",
        sentence=batch_sentence(rows.values()),
        failed={name: row["failure"] for name, row in rows.items() if row["failure"] is not None},
        lossy={name: row["recovered"] for name, row in rows.items() if row.get("recovered")},
        diagnosis=diagnosis,
        head=COLUMNS,
        rows=[(_link(name, row), *row_cells(name, row)[1:]) for name, row in rows.items()],
        parameters=parameter_tables(rows),
        versions=f"xneck {versions['xneck']}, Python {versions['python']}",
    )


def _link(name: str, row: Mapping[str, Any]) -> str | Markup:
    if row["failure"] is not None:
        return name
    # ./ keeps a name like `mail:me` from being taken for an address
    return Markup('<a href="./{}">{}</a>').format(quote(row["report"]), name)


def parameter_tables(rows: Rows) -> list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]]:
    """For each main parameter: title, columns, and a row for each recording with estimates."""
    tables = []
    for symbol, words in MAIN_PARAMETERS.items():
        by_recording = {
            name: {p["index"]: p for p in row["parameters"] if p["name"] == symbol}
            for name, row in rows.items()
            if row["failure"] is None
        }
        indices = sorted({index for by_index in by_recording.values() for index in by_index})
        if not indices:
            continue
        unit = next(p["unit"] for by_index in by_recording.values() for p in by_index.values())
        body = [(name, *(_value(by_index.get(index)) for index in indices)) for name, by_index in by_recording.items()]
        tables.append((f"{words.capitalize()} {symbol}, {unit}", ("recording", *(f"cable {i}" for i in indices)), body))
    return tables


def _value(p: Mapping[str, Any] | None) -> str:
    if p is None:
        return "–"
    if not p["identified"]:
        return "not identified"
    return with_sigma(p["value"], p["sigma"])
