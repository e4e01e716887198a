"""What was likely meant by a value that a file may not hold: another unit, a decimal comma."""

from collections.abc import Mapping
from contextlib import suppress
from math import isfinite, pi
from typing import Any

_OFTEN_TAKEN = {
    "m": ("mm", 1e-3),
    "m^2": ("mm^2", 1e-6),
    "rad": ("deg", pi / 180),
    "kg": ("g", 1e-3),
    "kg m^2": ("g cm^2", 1e-7),
}
"""by the unit that is expected, one in which people measure, and what it is"""
_LIMITS = ("le", "lt")


def likely_meant(found: Any, unit: str, context: Mapping[str, Any]) -> str:
    """What to say behind a value that was `found`, empty where nothing is likely; context: limits, as pydantic names them."""
    if isinstance(found, str):
        return _as_number(found)
    if isinstance(found, list):
        most = context.get("max_length")
        split = isinstance(most, int) and len(found) == 2 * most and all(isinstance(n, int) for n in found)
        return ", as decimal commas make of it: write decimals with a point" if split else ""
    limit = next((context[key] for key in _LIMITS if key in context), None)
    taken, scale = _OFTEN_TAKEN.get(unit, ("", 0.0))
    return f": is it in {taken}?" if limit is not None and taken and abs(found) * scale <= limit else ""


def _as_number(text: str) -> str:
    """The number that a text is, but for a decimal comma or a typographer's minus."""
    written = text.replace(",", ".", 1).replace("\N{MINUS SIGN}", "-").strip()
    with suppress(ValueError):
        return f": write {written}" if isfinite(float(written)) else ""
    return ""


def limit_text(limit: float) -> str:
    """A limit in the words of a refusal: 1e-9, 3.14159."""
    return str(limit) if isinstance(limit, int) else f"{limit:.6g}".replace("e-0", "e-")
