"""What is wrong with a CSV's header that lacks columns: separators, spelling, or that there is none."""

import re
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from synchronisation.column_meaning import column_meaning
from synchronisation.column_units import ANGLE_SCALES, TIME_SCALES
from synchronisation.csv_layout import SEPARATORS, CsvLayout, layout_of_lines
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed
from xneck_foundation.spelling import likely_spelling, quoted


class WrittenOtherwise(Refused):
    """A table has other columns or rows than those that are read, so that a mapping of it may help."""


def refuse_header_again(path: Path, line: int, header: Sequence[str], row: Sequence[str]) -> None:
    """Raises Refused where a row below the header is the header once more."""
    if [cell.strip() for cell in row] == list(header):
        what = f"its header stands again in row {line}, as where two recordings are joined"
        raise Refused(path, what, "cut them apart there")


def other_kind(columns: Collection[str], angles_expected: bool) -> tuple[str, str] | None:
    """What to say where joint angles were given in the place of the motors' log, or the other way round; None where neither was."""
    held = ("alpha1" in columns, "theta1" in columns)
    if held == (True, False) and not angles_expected:
        return "has alpha1: it holds joint angles, not the motors' log", "give the controller's log here"
    if held == (False, True) and angles_expected:
        return (
            "has theta1: it holds the motors' log, not joint angles",
            "give angles here; where both are given, they come first",
        )
    return None


IS_DATASET = ("is a data set of `xneck sync`, not the motors' log", "give the controller's log here")
"""what to say where a data set was given in the place of the motors' log"""


def is_dataset(topics: Collection[str]) -> bool:
    """Whether topics of an MCAP are those of a data set."""
    return {"state", "fasquelle"} <= set(topics)


_COUNTS = {"frame", "frames", "frame_number", "frame_id", "index", "idx", "sample", "row", "n", "no", "nr"}
"""what columns are called that number rows"""


def spelled_otherwise(header: Sequence[str], names: Sequence[str]) -> dict[str, str]:
    """Columns that the header lacks but for capitals, spaces, units and the like: how it spells them, by name."""
    cells, spelled = set(header), {_plain(cell): cell for cell in reversed(header)}
    return {name: spelled[name] for name in names if name not in cells and name in spelled}


def missing_columns(header: Sequence[str], row: Sequence[str], names: Sequence[str]) -> tuple[str, str]:
    """What a header (its cells, as commas part them) lacks of `names`, and what to do; row: the cells below it."""
    layout = layout_of_lines([",".join(header), ",".join(row)])
    if layout is not None and layout.separator != ",":
        return _otherwise_parted(header, layout, names)
    if header and all(_is_number(cell) for cell in header):
        return "has no header: its first row holds numbers", f"begin it with the row {listed(names, ',')}"
    cells_found = set(header)
    missing = [name for name in names if name not in cells_found]
    if names_of_angles := _angles_called_otherwise(header, names):
        return names_of_angles
    if otherwise := spelled_otherwise(header, missing):
        spelled = listed(f"{name} as {quoted(cell)}" for name, cell in otherwise.items())
        return (
            f"its header spells {spelled}",
            f"write {listed(otherwise, ',')} just so: small letters, no spaces, no units",
        )
    count = next((cell for cell in header if cell.lower() in _COUNTS), None)
    if missing[0] == names[0] and count and not any(column_meaning(c, np.empty(0)).kind == "time" for c in header):
        return (
            f"lacks the column {missing[0]}: {count} is a number of each row",
            "write the time of each row in seconds",
        )
    meant = likely_spelling(missing[0], [cell for cell in header if cell not in names])
    hint = f"is {meant} meant by {missing[0]}? " if meant else ""
    return (
        f"lacks the column{'s' * (len(missing) > 1)} {listed(missing)}",
        f"{hint}its header is '{listed(header, ',', 60)}', expected {listed(names, ',', 60)}",
    )


def _angles_called_otherwise(header: Sequence[str], names: Sequence[str]) -> tuple[str, str] | None:
    """What to say where a table of joint angles calls its columns otherwise, of all columns at once; None where it does not."""
    if "alpha1" not in names:
        return None
    meant = _likely_columns(header, names)
    called = {name: cell for name, cell in meant.items() if name != cell}
    if set(meant) != set(names) or not called:
        return None
    seen = listed(f"{name} {quoted(cell)}" for name, cell in called.items())
    factors = dict.fromkeys(f for name, cell in meant.items() if (f := _factor(name, cell)))
    do = ", and multiply ".join([f"write {listed(called, ',')} just so", *factors])
    return f"its header calls {seen}", do


def _likely_columns(header: Sequence[str], names: Sequence[str]) -> dict[str, str]:
    """The cell of a header that each name likely means: one that is called a time, and columns that a number tells apart."""
    columns = [column_meaning(cell, np.empty(0)) for cell in header]
    found = {name: name for name in names if name in header}
    time = next((c.name for c in columns if c.kind == "time"), None)
    if time is not None:
        found.setdefault(names[0], time)
    stems: dict[str, dict[int | None, str]] = {}
    for column in columns:
        stems.setdefault(column.stem, {})[column.number] = column.name
    wanted = range(1, len(names))
    fitting = [numbered for numbered in stems.values() if set(wanted) <= set(numbered)]
    if len(fitting) == 1:
        for j in wanted:
            found.setdefault(names[j], fitting[0][j])
    return found


def _factor(name: str, cell: str) -> str:
    """By what the unit in a header's cell is to be multiplied, empty where it is rad or s, or nothing is said."""
    is_angle = name.startswith("alpha")
    unit = column_meaning(cell, np.empty(0), "angle" if is_angle else "time").unit or ""
    scale = (ANGLE_SCALES if is_angle else TIME_SCALES).get(unit, 1.0)
    return "" if scale == 1.0 else f"{'alpha1..N' if is_angle else name} by {scale:.6g} ({unit})"


def _otherwise_parted(header: Sequence[str], layout: CsvLayout, names: Sequence[str]) -> tuple[str, str]:
    """What to say where columns are parted by something else than commas, by which the cells of the header are parted."""
    decimals = ", and its numbers have decimal commas" if layout.decimal == "," else ""
    what = f"its columns are parted by {dict(SEPARATORS)[layout.separator]}{decimals}"
    do = "write commas between columns, and points in numbers"
    cells = [cell.strip() for cell in ",".join(header).split(layout.separator)]
    if told := _angles_called_otherwise(cells, names):
        return f"{what}; {told[0]}", f"{do}; {told[1]}"
    return what, do


def parted_by_spaces(header: Sequence[str], row: Sequence[str]) -> tuple[str, str] | None:
    """What to say where a header and the row below it are one cell each of several words, those of the row numbers."""
    if len(header) != 1 or len(row) != 1:
        return None
    names, cells = ([word for word in text.strip().split(" ") if word] for text in (header[0], row[0]))
    if min(len(names), len(cells)) < 2 or not all(map(_is_number, cells)):
        return None
    return "its columns are parted by spaces", "write commas between columns"


def _plain(cell: str) -> str:
    """A column's name without capitals, units in brackets, and what is neither letter nor digit."""
    return re.sub(r"[^a-z0-9]", "", re.sub(r"[\[(].*?[\])]", "", cell.lower()))


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
