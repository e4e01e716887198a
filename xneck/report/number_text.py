"""Numbers as people read them."""

from math import floor, isfinite, log10


def number_text(value: float, digits: int = 4) -> str:
    """`value` to `digits` significant digits, thousands apart; with a power of ten where it is very small or very large."""
    if not isfinite(value):
        return "not known"
    if value == 0:
        return "0"
    exponent = floor(log10(abs(value)))
    if exponent < -4 or exponent > 7:
        mantissa, power = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa} × 10{_superscript(int(power))}"
    return f"{value:,.{max(0, digits - 1 - exponent)}f}".replace(",", "\u2009").replace("-", "\u2212")


def with_sigma(value: float, sigma: float) -> str:
    """`value ± sigma`, both to the second significant digit of sigma."""
    if not isfinite(value):
        return "not known"
    if not isfinite(sigma):
        return f"{number_text(value)} ± not known"
    if sigma <= 0:
        return number_text(value)
    places = max(0, 1 - floor(log10(sigma)))
    if places > 6:
        return f"{number_text(value)} ± {number_text(sigma, 2)}"
    return f"{value:,.{places}f} ± {sigma:,.{places}f}".replace(",", "\u2009").replace("-", "\u2212")


def percent(value: float) -> str:
    """A relative sigma, given in %, as text."""
    if not isfinite(value):
        return "not known"
    return f"{value:.3g} %" if value < 1000 else "above 1000 %"


def file_size(count: int) -> str:
    """`count` bytes as text, in a suitable unit."""
    for unit, factor in (("MB", 1e6), ("kB", 1e3)):
        if count >= factor:
            return f"{number_text(count / factor, 3)} {unit}"
    return f"{count} bytes"


def _superscript(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
