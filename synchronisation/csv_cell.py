"""What a cell of a table is: a number, or what else it looks like."""

import re

_MISSING = "leave such rows out of a log; of angles leave such cells empty"
_DECIMAL_COMMA = r"[+-]?(\d+|[1-9]\d{0,2}(\.\d{3})+),\d*([eE][+-]?\d+)?"
_THOUSANDS = r"[+-]?[1-9]\d{0,2}(\.\d{3})+(,\d*)?([eE][+-]?\d+)?"
_KINDS = (
    (r"\d{4}-\d\d?-\d\d?([T ].*)?", "is a date", "write the time in seconds, of any beginning"),
    (r"\d\d?[/.,]\d\d?[/.,]\d{4}.*", "is a date", "write the time in seconds, of any beginning"),
    (r"\d\d?-[^\W\d_]{3,9}\.?-\d{4}.*", "is a date", "write the time in seconds, of any beginning"),
    (r"\d+:\d\d(:\d\d([.,]\d+)?)?", "is a time of day", "write the time in seconds, of any beginning"),
    (r"#(N/A|DIV/0!|REF!|VALUE!|NAME\?|NUM!|NULL!|WERT!|BEZUG!|ZAHL!)", "is an error of a spreadsheet", _MISSING),
    (r"(?i)n/?a|null|none|-+|\?+", "is not a number", _MISSING),
    (r"[+-]?0[xX][0-9a-fA-F.]+([pP][+-]?\d+)?", "is a hexadecimal number", "write decimal numbers"),
    (_DECIMAL_COMMA, "has a decimal comma", "write points in numbers"),
    (r"\u2212[\d.,]+([eE][+-]?\d+)?", "has the minus sign of printed text (U+2212)", "write hyphens in numbers"),
    (r"[+-]?[\d.]+[dD][+-]?\d+", "has a Fortran exponent", "write e in numbers, not d"),
)

MOMENTS = ("is a date", "is a time of day")
"""what is said of cells that tell when a row was"""


def not_a_number(cell: str) -> tuple[str, str]:
    """What to say of a cell that is no number, and what to do, which is empty where nothing is known."""
    for pattern, what, do in _KINDS:
        if re.fullmatch(pattern, cell.strip()):
            return what, do
    return "is not a number", ""


def has_decimal_comma(cell: str) -> bool:
    """Whether a cell is a number but for a comma before its decimals."""
    return re.fullmatch(_DECIMAL_COMMA, cell.strip()) is not None


def with_point(cell: str, decimal: str) -> str:
    """A cell whose decimals stand behind `decimal`, with a point there, and none between its thousands."""
    if decimal == ".":
        return cell
    if "." in cell and re.fullmatch(_THOUSANDS, cell.strip()):
        cell = cell.replace(".", "")
    return cell.replace(decimal, ".")


def unit_in(cell: str) -> str:
    """What a cell of a row of units says, without the brackets that some programs put around it."""
    return cell.strip().strip("[]()")


def number_in(cell: str) -> float:
    """The number in a cell, NaN for an empty one. Raises ValueError, also for 1_0, which Python alone takes for 10."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell) if cell.strip() else float("nan")


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, or nothing."""
    try:
        number_in(cell)
    except ValueError:
        return False
    return True
