"""What is wrong with a CSV's header that lacks columns: separators, spelling, or that there is none."""

import re
from collections.abc import Collection, Sequence

from synchronisation.csv_layout import SEPARATORS, layout_of_lines
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed
from xneck_foundation.spelling import likely_spelling, quoted


class WrittenOtherwise(Refused):
    """A table has other columns or rows than those that are read, so that a mapping of it may help."""


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


def spelled_otherwise(header: Sequence[str], names: Sequence[str]) -> dict[str, str]:
    """Columns that the header lacks but for capitals, spaces, units and the like: how it spells them, by name."""
    cells, spelled = set(header), {_plain(cell): cell for cell in reversed(header)}
    return {name: spelled[name] for name in names if name not in cells and name in spelled}


def missing_columns(header: Sequence[str], row: Sequence[str], names: Sequence[str]) -> tuple[str, str]:
    """What a header (its cells, as commas part them) lacks of `names`, and what to do; row: the cells below it."""
    if (written := _otherwise_parted(header, row)) is not None:
        return written
    if header and all(_is_number(cell) for cell in header):
        return "has no header: its first row holds numbers", f"begin it with the row {listed(names, ',')}"
    cells_found = set(header)
    missing = [name for name in names if name not in cells_found]
    if otherwise := spelled_otherwise(header, missing):
        spelled = listed(f"{name} as {quoted(cell)}" for name, cell in otherwise.items())
        return (
            f"its header spells {spelled}",
            f"write {listed(otherwise, ',')} just so: small letters, no spaces, no units",
        )
    meant = likely_spelling(missing[0], [cell for cell in header if cell not in names])
    hint = f"is {meant} meant by {missing[0]}? " if meant else ""
    return (
        f"lacks the column{'s' * (len(missing) > 1)} {listed(missing)}",
        f"{hint}its header is '{listed(header, ',', 60)}', expected {listed(names, ',', 60)}",
    )


def _otherwise_parted(header: Sequence[str], row: Sequence[str]) -> tuple[str, str] | None:
    """What to say where a header and the row below it, whose cells commas part, are parted by something else."""
    layout = layout_of_lines([",".join(header), ",".join(row)])
    if layout is None or layout.separator == ",":
        return None
    decimals = ", and its numbers have decimal commas" if layout.decimal == "," else ""
    what = f"its columns are parted by {dict(SEPARATORS)[layout.separator]}{decimals}"
    return what, "write commas between columns, and points in numbers"


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
