"""The summary of a batch in words: a row for each recording, and the count."""

from collections.abc import Iterable, Mapping
from typing import Any

from xneck.recording.result_files import DIAGNOSIS_FOLDER, DIAGNOSIS_PAGE
from xneck.report.number_text import number_text
from xneck.report.words import join_words

COLUMNS = ("recording", "frames", "clock offset", "check", "identified", "model", "")
MAIN_PARAMETERS = {"k": "stiffness", "ca": "damping", "fs": "dry friction", "fv": "viscous friction"}
_NONE = "–"


def diagnosis_row(record: Mapping[str, Any]) -> dict[str, Any]:
    """What the summary repeats of diagnosis.json; the path `report` is relative to the summary."""
    repeated = {key: record[key] for key in ("verdict", "sentence", "causes")}
    return repeated | {"report": f"{DIAGNOSIS_FOLDER}/{DIAGNOSIS_PAGE}"}


def row_cells(name: str, row: Mapping[str, Any]) -> tuple[str, ...]:
    """The cells of a recording's row, one for each of COLUMNS."""
    if row["failure"] is not None:
        return (
            name,
            *(_NONE,) * (len(COLUMNS) - 2),
            f"failed: {row['failure']}" + (" (as before)" if row["done_before"] else ""),
        )
    faults = sorted({_fault_text(fault) for fault in row["faults"]})
    took = "done before" if row["done_before"] else f"took {number_text(row['seconds'], 2)} s"
    notes = [join_words(faults)] * bool(faults) + row["recovered"] + [took]
    return (
        name,
        f"{row['frames_used']} of {row['frames']}",
        f"{number_text(row['offset_s'], 5)} s ± {number_text(1e3 * row['offset_sigma_s'], 2)} ms",
        row["verdict"],
        ", ".join(_identified_counts(row["parameters"])) or "none",
        _times_noise(row["adequacy"]),
        "; ".join(notes),
    )


def _times_noise(adequacy: Mapping[str, Any] | None) -> str:
    if adequacy is None:
        return "not simulated"
    return f"{number_text(adequacy['ratio'], 2 if adequacy['explains'] else 3)} × noise"


def _fault_text(fault: Mapping[str, Any]) -> str:
    name, where = fault["fault"].replace("_", " "), fault["where"]
    return name if where == "all" else f"{name} at {where}"


def _identified_counts(parameters: Iterable[Mapping[str, Any]]) -> list[str]:
    """`k` where it is identified of every cable, then such as `ca 2 of 4`; without those that are identified of none."""
    identified: dict[str, list[bool]] = {}
    for p in parameters:
        identified.setdefault(p["name"], []).append(p["identified"])
    names = [name for name in MAIN_PARAMETERS if any(identified.get(name, ()))]
    complete = [name for name in names if all(identified[name])]
    partial = [name for name in names if name not in complete]
    return complete + [f"{name} {sum(identified[name])} of {len(identified[name])}" for name in partial]


def identified_lines(parameters: Iterable[Mapping[str, Any]]) -> list[str]:
    """A line for each main parameter that is identified of a cable: its values with sigma, in the order of cables."""
    every = list(parameters)
    lines = []
    for name, words in MAIN_PARAMETERS.items():
        named = [p for p in every if p["name"] == name]
        if any(p["identified"] for p in named):
            values = ", ".join(_with_sigma(p) if p["identified"] else "not identified" for p in named)
            lines.append(f"  {words} {name}: {values} {named[0]['unit']}")
    return lines


def _with_sigma(p: Mapping[str, Any]) -> str:
    return f"{p['value']:.5g} +- {p['sigma']:.2g}"


def batch_sentence(rows: Iterable[Mapping[str, Any]]) -> str:
    """How many recordings there are, how many are done, failed, and were known from an earlier run."""
    every = list(rows)
    failed = sum(row["failure"] is not None for row in every)
    before = sum(row["done_before"] for row in every)
    known = f"; {before} of them known from before" if before else ""
    return f"{len(every)} recordings: {len(every) - failed} done, {failed} failed{known}"


def batch_text(rows: Mapping[str, Mapping[str, Any]]) -> str:
    """The table with aligned columns for a terminal, and the count below it."""
    lines = [COLUMNS, *(row_cells(name, row) for name, row in rows.items())]
    widths = [max(len(line[i]) for line in lines) for i in range(len(COLUMNS))]
    table = ["  ".join(f"{c:<{w}}" for c, w in zip(line, widths, strict=True)).rstrip() for line in lines]
    return "\n".join([*table, batch_sentence(rows.values())])
