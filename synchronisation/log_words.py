"""What was found in an unknown log, in words and as a record, and the lines for neck.yaml."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from synchronisation.column_meaning import Column
from synchronisation.log_contents import LogContents
from synchronisation.log_mapping import LogMapping, survey
from xneck_foundation.one_line import counted, listed
from xneck_foundation.yaml_text import flow

_MAX_COLUMNS = 60
_MAX_GAPS = 3
_KINDS = {
    "time": "time",
    "angle": "angle of a motor",
    "force": "force",
    "current": "current of a motor",
    "speed": "speed, not needed",
    "error": "an error or an offset, not needed",
    "light": "light",
    "other": "unknown, not needed",
}


def contents_lines(path: Path, contents: LogContents) -> Iterator[str]:
    """What is in the file: each column or joint with its range, and what it likely is."""
    for topic, columns in survey(contents):
        if topic:
            channel = contents.topics[topic]
            yield f"{path}: topic /{topic}, {len(channel.time)} messages of {counted(len(channel.names), 'joint')}"
        else:
            rows = len(next(iter(contents.columns.values()))) if contents.columns else 0
            yield f"{path}: {counted(rows, 'row')} of {counted(len(columns) + len(contents.texts), 'column')}"
        if contents.written.separator != ",":
            decimal = ", decimals with a comma" if contents.written.decimal == "," else ""
            yield f"  columns are parted by {flow(contents.written.separator)}{decimal}"
        width = min(max((len(c.name) for c in columns), default=0), 30)
        yield from (f"  {column.name:{width}}  {_column_words(column)}" for column in columns[:_MAX_COLUMNS])
        if len(columns) > _MAX_COLUMNS:
            yield f"  ... and {len(columns) - _MAX_COLUMNS} more"
    yield from (f"{path}: topic /{topic}: cannot be read ({fault})" for topic, fault in contents.faults.items())
    if contents.texts:
        yield f"  no numbers: {listed(contents.texts)}"
    if contents.units_row:
        yield f"  row {contents.units_row} holds units: they are taken for those of the columns"
    if contents.odd_rows:
        rows = listed(map(str, contents.odd_rows), limit=40)
        yield f"  more or fewer cells than the header in row {rows}: mend them or leave them out, so that it can be read"


def mapping_lines(mapping: LogMapping) -> Iterator[str]:
    """What is taken for what, and what nothing in the log says."""
    yield f"{mapping.seconds:.1f} s at {mapping.rate:.4g} rows a second; {_gap_words(mapping)}"
    if mapping.repeated:
        rows = f"{counted(mapping.repeated, 'row')} with the time of the one before"
        yield f"{rows}: one that repeats another in full is left out, any other must have a time of its own"
    yield f"angles of {counted(mapping.motors, 'motor')}: {listed(a.name for a in mapping.angles)}"
    if mapping.forces:
        turned = ", nearly all negative: turned over, as cables only pull" if mapping.pushing else ""
        yield f"forces: {listed(f.name for f in mapping.forces)}{turned}"
    still = [c.name for c in (*mapping.angles, *mapping.forces) if c.constant]
    if still:
        yield f"never changing: {listed(still)}"
    yield from (f"before it can be read: {what}" for what in mapping.to_mend)
    yield from (f"not told by the log: {doubt}" for doubt in mapping.doubts)


def snippet(log: dict[str, Any], motors: Sequence[dict[str, Any]]) -> str:
    """The mapping as lines of neck.yaml; of each motor those keys that the log is about."""
    lines = [f"log: {flow(log)}"] if log else []
    return "\n".join([*lines, "motors:", *(f"  - {{..., {flow(keys)[1:]}" for keys in motors)])


def mapping_record(
    contents: LogContents, mapping: LogMapping, log: dict[str, Any], motors: list[dict[str, Any]]
) -> dict[str, Any]:
    """What was found, for `--json`."""
    return {
        "topics": [
            {"topic": topic or None, "columns": [_column_record(c) for c in columns]}
            for topic, columns in survey(contents)
        ],
        "unreadable_topics": [{"topic": topic, "why": fault} for topic, fault in contents.faults.items()],
        "rate_hz": mapping.rate,
        "seconds": mapping.seconds,
        "gaps": [{"begin_s": begin, "seconds": length} for begin, length in mapping.gaps],
        "mapping": {"log": log, "motors": motors, "topic": mapping.topic},
        "doubts": list(mapping.doubts),
        "to_mend": list(mapping.to_mend),
    }


def _column_words(column: Column) -> str:
    unit = f" in {column.unit}" + (" by its values" if column.unit_by == "values" else "") if column.unit else ""
    missing = f", {counted(column.missing, 'row')} without a number" if column.missing else ""
    limits = "no numbers" if np.isnan(column.low) else f"{column.low:.6g} to {column.high:.6g}"
    commanded = ", as commanded" if column.commanded else ", as measured" if column.measured else ""
    return f"{limits}: {_KINDS[column.kind]}{unit}{commanded}{missing}"


def _gap_words(mapping: LogMapping) -> str:
    if not mapping.gaps:
        return "no pauses"
    shown = [f"{length:.2f} s at {begin:.1f} s" for begin, length in mapping.gaps[:_MAX_GAPS]]
    more = f" and {len(mapping.gaps) - _MAX_GAPS} more" if len(mapping.gaps) > _MAX_GAPS else ""
    return f"pauses of {', '.join(shown)}{more}"


def _column_record(column: Column) -> dict[str, Any]:
    return {
        "name": column.name,
        "kind": column.kind,
        "unit": column.unit,
        "unit_by": column.unit_by or None,
        "commanded": column.commanded,
        "measured": column.measured,
        "low": column.low,
        "high": column.high,
        "missing": column.missing,
    }
