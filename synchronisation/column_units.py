"""Units that loggers write into columns' names, or into a row below them: which are known, and of what they are units."""

import re
from typing import Literal

import numpy as np

Kind = Literal["time", "angle", "force", "current", "speed", "error", "light", "other"]

TIME_SCALES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "days": 86400.0}
"""s per unit"""
ANGLE_SCALES = {"rad": 1.0, "mrad": 1e-3, "deg": np.pi / 180, "turns": 2 * np.pi}
"""rad per unit"""
CABLE_SCALES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
"""m per unit, of cables that are logged in the place of angles"""
_GRAVITY, _POUND, _INCH = 9.80665, 4.4482216152605, 0.0254
"""m/s^2, N, m: each is so by definition"""
FORCE_SCALES = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "daN": 10.0, "kgf": _GRAVITY, "gf": 1e-3 * _GRAVITY, "lbf": _POUND}
"""N per unit"""
TORQUE_SCALES = {
    "N m": 1.0,
    "mN m": 1e-3,
    "N cm": 1e-2,
    "N mm": 1e-3,
    "kgf cm": 1e-2 * _GRAVITY,
    "gf cm": 1e-5 * _GRAVITY,
    "lbf in": _POUND * _INCH,
    "ozf in": _POUND * _INCH / 16,
}
"""N m per unit"""

_BY_WORD: dict[str, tuple[str, Kind]] = {
    **dict.fromkeys(("s", "sec", "secs", "seconds", "sek"), ("s", "time")),
    **dict.fromkeys(("ms", "msec", "millis", "milliseconds"), ("ms", "time")),
    **dict.fromkeys(("us", "µs", "μs", "usec", "micros", "microseconds"), ("us", "time")),
    **dict.fromkeys(("ns", "nanos", "nsec", "nsecs", "nanosec", "nanosecs", "nanoseconds"), ("ns", "time")),
    **dict.fromkeys(("min", "minutes", "minuten"), ("min", "time")),
    **dict.fromkeys(("h", "hours"), ("h", "time")),
    **dict.fromkeys(("days", "tage"), ("days", "time")),
    **dict.fromkeys(("rad", "radian", "radians"), ("rad", "angle")),
    "mrad": ("mrad", "angle"),
    **dict.fromkeys(("deg", "degree", "degrees", "°", "grad"), ("deg", "angle")),
    **dict.fromkeys(("rev", "revs", "turn", "turns", "umdr", "umdrehungen"), ("turns", "angle")),
    **dict.fromkeys(
        ("cnt", "cnts", "count", "counts", "ticks", "inc", "inkremente", "qc", "pulses"), ("counts", "angle")
    ),
    "n": ("N", "force"),
    "mn": ("mN", "force"),
    "kn": ("kN", "force"),
    "dan": ("daN", "force"),
    **dict.fromkeys(("kgf", "kp"), ("kgf", "force")),
    "gf": ("gf", "force"),
    **dict.fromkeys(("lbf", "lbs"), ("lbf", "force")),
    "nm": ("N m", "force"),
    "mnm": ("mN m", "force"),
    "ncm": ("N cm", "force"),
    "nmm": ("N mm", "force"),
    **dict.fromkeys(("kgfcm", "kgcm"), ("kgf cm", "force")),
    **dict.fromkeys(("gfcm", "gcm"), ("gf cm", "force")),
    **dict.fromkeys(("lbfin", "lbin", "inlb", "inlbf"), ("lbf in", "force")),
    **dict.fromkeys(("ozfin", "ozin", "inoz"), ("ozf in", "force")),
    **dict.fromkeys(("pct", "percent", "prozent"), ("%", "force")),
    **dict.fromkeys(("a", "amp", "amps", "ampere"), ("A", "current")),
    "ma": ("mA", "current"),
}
"""units, and of what they are, by the words that names hold"""
_BY_TEXT: dict[str, tuple[str, Kind]] = {
    **_BY_WORD,
    "u": ("turns", "angle"),
    "m": ("m", "angle"),
    "cm": ("cm", "angle"),
    "mm": ("mm", "angle"),
    "kg": ("kgf", "force"),
    "g": ("gf", "force"),
    "lb": ("lbf", "force"),
    "%": ("%", "force"),
    "rpm": ("rpm", "speed"),
    "hz": ("Hz", "speed"),
}
"""the same of what stands in brackets or in a row of units, where short words too are units"""
_RATE = re.compile(r"/(s|sec|min|h)\b|s\^?-\d|/s²")
_IN_BRACKETS = re.compile(r"\s*[\[(]([^\[\]()]*)[\])]\s*$")
_MAX_LETTERS = 12
"""of a unit: more are words of something else"""


def unit_of_word(word: str, kind: Kind) -> str | None:
    """The unit that a word of a name says, small; None where it is none of that kind."""
    unit, of = _BY_WORD.get(word, ("", "other"))
    return unit if unit and of in (kind, "current" if kind == "force" else kind) else None


def kind_of_word(word: str) -> Kind | None:
    """Of what a word is the unit; None where it is one letter, or no unit."""
    return _BY_WORD[word][1] if word in _BY_WORD and len(word) > 1 else None


def unit_of_text(text: str) -> tuple[str, Kind] | None:
    """The unit that a text says which can be nothing else, and of what it is one; None where it is not known."""
    if _RATE.search(text.lower()):
        return text, "speed"
    return _BY_TEXT.get(re.sub(r"[\s.*·⋅_\-]", "", text.lower()))


def without_brackets(name: str) -> tuple[str, str]:
    """A name without what stands in brackets at its end, and that text, which is empty where it is a number or a remark."""
    found = _IN_BRACKETS.search(name)
    if found is None or not found.start():
        return name, ""
    text = found[1].strip()
    if unit_of_text(text) is None and (not text or len(text) > _MAX_LETTERS or any(c.isdigit() for c in text)):
        return name, ""
    return name[: found.start()], text
