"""What a batch comes to, a recording a row: for people on the terminal, and as records."""

from collections.abc import Iterable, Mapping
from typing import Any

from xneck.batch.batch import Ended
from xneck.report.wording import listed, number

HEAD = ("recording", "frames", "clock offset", "check", "identified", "took", "")
MAIN = {"k": "stiffness", "ca": "damping", "fs": "dry friction", "fv": "viscous friction"}
DIAGNOSIS = "diagnosis"
"""folder of the diagnosis of all, beside the recordings' own"""
_NONE = "–"


def as_json(one: Ended) -> dict[str, Any]:
    """A row's numbers; `report` as seen from the summary."""
    row: dict[str, Any] = {"done_before": one.before, "failure": one.failure}
    if one.record is None:
        return row
    sync, check = one.record["sync"], one.record["check"]
    return row | {
        "report": f"{one.name}/{one.record['report']}",
        "seconds": one.record["seconds"],
        "frames": sync["frames"],
        "frames_used": sync["frames_used"],
        "offset_s": sync["offset_s"],
        "offset_sigma_s": sync["offset_sigma_s"],
        "verdict": check["verdict"],
        "faults": check["faults"],
        "parameters": [p for p in one.record["identify"]["parameters"] if p["name"] in MAIN],
        "recovered": one.record["recovered"],
    }


def diagnosis(record: Mapping[str, Any]) -> dict[str, Any]:
    """What the summary says of diagnosis.json; `report` as seen from the summary."""
    told = {key: record[key] for key in ("verdict", "sentence", "causes")}
    return told | {"report": f"{DIAGNOSIS}/{DIAGNOSIS}.html"}


def cells(name: str, row: Mapping[str, Any]) -> tuple[str, ...]:
    """A row in words, under HEAD."""
    if row["failure"] is not None:
        return (name, *(_NONE,) * 5, f"failed: {row['failure']}" + (" (as before)" if row["done_before"] else ""))
    faults = sorted({_spoken(fault) for fault in row["faults"]})
    notes = [listed(faults)] * bool(faults) + row["recovered"] + ["done before"] * row["done_before"]
    return (
        name,
        f"{row['frames_used']} of {row['frames']}",
        f"{number(row['offset_s'], 5)} s ± {number(1e3 * row['offset_sigma_s'], 2)} ms",
        row["verdict"],
        ", ".join(_counted(row["parameters"])) or "none",
        f"{number(row['seconds'], 2)} s",
        "; ".join(notes),
    )


def _spoken(fault: Mapping[str, Any]) -> str:
    name, where = fault["fault"].replace("_", " "), fault["where"]
    return name if where == "all" else f"{name} at {where}"


def _counted(parameters: Iterable[Mapping[str, Any]]) -> list[str]:
    """`k`, then `ca 2 of 4` of those not all of which are identified; nothing of those of which none is."""
    good: dict[str, list[bool]] = {}
    for p in parameters:
        good.setdefault(p["name"], []).append(p["identified"])
    told = [name for name in MAIN if any(good.get(name, ()))]
    whole = [name for name in told if all(good[name])]
    return whole + [f"{name} {sum(good[name])} of {len(good[name])}" for name in told if name not in whole]


def sentence(rows: Iterable[Mapping[str, Any]]) -> str:
    """How many there are, are done, and failed."""
    every = list(rows)
    failed = sum(row["failure"] is not None for row in every)
    before = sum(row["done_before"] for row in every)
    return f"{len(every)} recordings: {len(every) - failed} done, {failed} failed; {before} of them known from before"


def as_text(rows: Mapping[str, Mapping[str, Any]]) -> str:
    """Aligned columns, and the count."""
    lines = [HEAD, *(cells(name, row) for name, row in rows.items())]
    widths = [max(len(line[i]) for line in lines) for i in range(len(HEAD))]
    table = ["  ".join(f"{c:<{w}}" for c, w in zip(line, widths, strict=True)).rstrip() for line in lines]
    return "\n".join([*table, sentence(rows.values())])
