"""Units as people read them: what is a ratio has none, though records say `1`."""

RATIO = "1"
"""the unit of a ratio in records"""


def printed_unit(unit: str) -> str:
    """A unit as it stands in a table of its own column: nothing for a ratio."""
    return "" if unit == RATIO else unit


def with_unit(text: str, unit: str) -> str:
    """A number with its unit behind it; that of a ratio is not printed."""
    return text if unit == RATIO else f"{text} {unit}"


def product_unit(first: str, second: str) -> str:
    """The unit of a product of two quantities."""
    return " ".join(unit for unit in (first, second) if unit != RATIO) or RATIO
