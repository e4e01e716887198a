"""The benchmarks as one HTML page: the claims in one table, then each topic's own, and what they ran on."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from benchmarks.run import Ended
from benchmarks.summary import HEAD, claims
from benchmarks.table import Named
from benchmarks.topic import table_of
from xneck.report.template import render
from xneck.report.wording import listed, number
from xneck_foundation.whole_file import write_text

_NONE = "–"
TEMPLATE = Path(__file__).with_name("benchmarks.html.jinja")


def write_page(ended: Sequence[Ended], wanting: Sequence[str], command: str, path: Path) -> None:
    """The page, whole or not at all. `wanting`: topics that have not been run."""
    write_text(path, page(ended, wanting, command))


def page(ended: Sequence[Ended], wanting: Sequence[str], command: str) -> str:
    """The HTML."""
    done = [(one.name, one.record, table_of(one.record)) for one in ended if one.record]
    failed = [one for one in ended if one.failure]
    return render(
        TEMPLATE,
        sentence=sentence(len(done), [one.name for one in failed], wanting),
        head=HEAD,
        rows=[
            (
                _to(name, claim.what),
                _figure(claim.ours),
                _named(claim.peer),
                _figure(claim.ratio),
                _named(claim.limit),
                _label(claim.on),
            )
            for name, claim in claims(ended)
        ]
        + [(_to(one.name, one.name), "failed", _NONE, _NONE, _NONE, _label(one.failure or "")) for one in failed],
        topics=[(name, record, table, _cells(table.rows)) for name, record, table in done],
        failed=failed,
        machine=_machine([record for _, record, _ in done]),
        command=command,
        number=number,
    )


def sentence(done: int, failed: Sequence[str], wanting: Sequence[str]) -> str:
    """How many topics there are, and which are missing."""
    words = f"{done} topic{'s' * (done != 1)} measured"
    words += f"; {listed(failed)} failed" if failed else ""
    return words + (f"; not run: {listed(wanting)}" if wanting else "")


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
    return _NONE if value is None else number(value)


def _named(other: Named | None) -> str | Markup:
    return _NONE if other is None else Markup("{}<small>{}</small>").format(_figure(other[1]), other[0])


def _to(topic: str, words: str) -> Markup:
    return _label(Markup('<a href="#{}">{}</a>').format(topic, words))


def _label(words: str) -> Markup:
    """Wide enough to be read where the table is wider than the screen."""
    return Markup('<div class="label">{}</div>').format(words)
