"""Figures of the record of thresholds: what half and twice of each make of right and of false verdicts."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from benchmarks.thresholds.record import Record


def threshold_figures(record: Record) -> dict[str, str]:
    """By name of the figure: `thresholds.ROOM.LABEL.half` and `.twice`, of each room how many worlds are right and false, what is
    not right as things are (`thresholds.not_right`), and what changes a verdict (`thresholds.changes`)."""
    figures = {
        "thresholds.changes": _list(_changes(record)),
        "thresholds.not_right": _list(
            f"- {room.replace('_', ' ')}: {world}" for room, found in record.items() for world in found["not_right"]
        ),
    }
    for room, found in record.items():
        figures[f"thresholds.{room}"] = f"{found['right']} of {found['worlds']} right, {found['false']} false"
        for label, tried in found["thresholds"].items():
            for which, counts in tried.items():
                figures[f"thresholds.{room}.{label.lower()}.{which}"] = _cell(counts)
    return figures


def _changes(record: Record) -> Iterator[str]:
    for found in record.values():
        for label, tried in found["thresholds"].items():
            for which, counts in tried.items():
                if counts["changed"]:
                    worlds = ", ".join(counts["changed"])
                    yield f"- `{label}`, {which}{_at(counts['value'])}: {_cell(counts)} ({worlds})"


def _at(value: str) -> str:
    try:
        return f" ({float(value):.3g})"
    except ValueError:  # a tuple, or a table that has no short form
        return f" {value}" if value else ""


def _list(lines: Iterable[str]) -> str:
    return "\n".join(["", *(list(lines) or ["- None."]), ""])


def _cell(counts: Mapping[str, Any]) -> str:
    """Such as `12/12 -> 10/12, false 0 -> 1`, or `12/12` where no world's verdict came out otherwise."""
    of = counts["worlds"]
    (right, right_now), (false, false_now) = counts["right"], counts["false"]
    if not counts["changed"]:
        return f"{right}/{of}"
    others = " (others)" if (right, false) == (right_now, false_now) else ""
    return f"{right}/{of} -> {right_now}/{of}{others}, false {false} -> {false_now}"
