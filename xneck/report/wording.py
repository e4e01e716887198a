"""Numbers as people read them."""

from collections.abc import Sequence
from math import floor, isfinite, log10


def number(value: float, digits: int = 4) -> str:
    """`value` with so many significant digits, thousands apart, powers of ten only where zeros would be counted."""
    if not isfinite(value):
        return "not known"
    if value == 0:
        return "0"
    exponent = floor(log10(abs(value)))
    if exponent < -4 or exponent > 7:
        mantissa, power = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa} × 10{_raised(int(power))}"
    return f"{value:,.{max(0, digits - 1 - exponent)}f}".replace(",", "\u2009").replace("-", "\u2212")


def with_sigma(value: float, sigma: float) -> str:
    """`value ± sigma`, both to the second significant digit of sigma."""
    if not isfinite(value):
        return "not known"
    if not isfinite(sigma):
        return f"{number(value)} ± not known"
    if sigma <= 0:
        return number(value)
    places = max(0, 1 - floor(log10(sigma)))
    if places > 6:
        return f"{number(value)} ± {number(sigma, 2)}"
    return f"{value:,.{places}f} ± {sigma:,.{places}f}".replace(",", "\u2009").replace("-", "\u2212")


def percent(value: float) -> str:
    """A relative sigma."""
    if not isfinite(value):
        return "not known"
    return f"{value:.3g} %" if value < 1000 else "above 1000 %"


def size_of(count: int) -> str:
    """Bytes."""
    for unit, factor in (("MB", 1e6), ("kB", 1e3)):
        if count >= factor:
            return f"{number(count / factor, 3)} {unit}"
    return f"{count} bytes"


def listed(words: Sequence[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


def _raised(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
