"""The benchmarks as one HTML page: the claims in one table, then each topic's own, and what they ran on."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from benchmarks.run import TopicOutcome
from benchmarks.summary import HEAD, claims
from benchmarks.table import Named
from benchmarks.topic import table_of
from xneck.report.number_text import number_text
from xneck.report.template import render
from xneck.report.words import join_words
from xneck_foundation.whole_file import write_text

_NONE = "–"
TEMPLATE = Path(__file__).with_name("benchmarks.html.jinja")


def write_page(outcomes: Sequence[TopicOutcome], not_run: Sequence[str], command: str, path: Path) -> None:
    """The page, whole or not at all. `not_run`: topics that have not been run."""
    write_text(path, page(outcomes, not_run, command))


def page(outcomes: Sequence[TopicOutcome], not_run: Sequence[str], command: str) -> str:
    """The HTML."""
    measured = [(outcome.name, outcome.record, table_of(outcome.record)) for outcome in outcomes if outcome.record]
    failed = [outcome for outcome in outcomes if outcome.failure]
    return render(
        TEMPLATE,
        sentence=sentence(len(measured), [outcome.name for outcome in failed], not_run),
        head=HEAD,
        rows=[
            (
                _link(name, claim.what),
                _figure(claim.ours),
                _named_figure(claim.peer),
                _figure(claim.ratio),
                _named_figure(claim.limit),
                _label(claim.on),
            )
            for name, claim in claims(outcomes)
        ]
        + [
            (_link(outcome.name, outcome.name), "failed", _NONE, _NONE, _NONE, _label(outcome.failure or ""))
            for outcome in failed
        ],
        topics=[(name, record, table, _cells(table.rows)) for name, record, table in measured],
        failed=failed,
        machine=_machine([record for _, record, _ in measured]),
        command=command,
        number=number_text,
    )


def sentence(measured: int, failed: Sequence[str], not_run: Sequence[str]) -> str:
    """How many topics there are, and which are missing."""
    words = f"{measured} topic{'s' * (measured != 1)} measured"
    words += f"; {join_words(failed)} failed" if failed else ""
    return words + (f"; not run: {join_words(not_run)}" if not_run else "")


def _machine(records: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
    """What measured, in words; all records that still hold are of one machine."""
    if not records:
        return []
    m = records[0]["made_by"]["machine"]
    return [
        ("Processor", f"{m['processor']}, {m['cores']} cores, {m['system']}"),
        ("xneck", m["xneck"]),
        ("Python", m["python"]),
        *m["libraries"].items(),
    ]


def _cells(rows: Sequence[tuple[str, Sequence[float | None]]]) -> list[tuple[str, ...]]:
    return [(_label(label), *map(_figure, figures)) for label, figures in rows]


def _figure(value: float | None) -> str:
    return _NONE if value is None else number_text(value)


def _named_figure(other: Named | None) -> str | Markup:
    return _NONE if other is None else Markup("{}<small>{}</small>").format(_figure(other[1]), other[0])


def _link(topic: str, words: str) -> Markup:
    return _label(Markup('<a href="#{}">{}</a>').format(topic, words))


def _label(words: str) -> Markup:
    """Wide enough to be read where the table is wider than the screen."""
    return Markup('<div class="label">{}</div>').format(words)
