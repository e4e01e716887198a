"""What a diagnosis should measure of an effect that is hidden: the truth in the diagnosis's own numbers, where both mean the same.

Laws of another form have none: joint friction (arctan against tanh), hysteresis (Maxwell's elements against Dahl's), exponential
hardening, the depth of slack. Nor has a clock's offset, which the clocks' fit takes away in part.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any

Numbers = dict[tuple[str, int | None], float]
"""by name and index, as in a record's parameters"""
Own = Mapping[str, float]
"""what the truth says of an effect"""

_AT_M = 5e-3
"""elongation at which hardening of all powers agrees: k2 (5 mm)^2 (x / 5 mm)^3 is k3 x^3"""


def expected(hidden: Mapping[str, Any], truth: Mapping[str, Any]) -> Numbers:
    """True numbers of a `hidden` entry of the truth; none where the laws' forms differ."""
    form = _EXPECTED.get(hidden["effect"])
    if form is None:
        return {}
    place = re.search(r"\d+$", hidden["where"])
    return form(hidden["parameters"], truth, int(place[0]) if place else None)


def _numbered(own: Own, name: str, here: str, factor: float = 1.0) -> Numbers:
    """name1 .. nameM of the truth, as the term `here`."""
    found = ((re.fullmatch(rf"{name}(\d+)", key), value) for key, value in own.items())
    return {(here, int(match[1])): factor * value for match, value in found if match}


def _hardening(own: Own, truth: Mapping[str, Any], place: int | None) -> Numbers:
    cubic = _numbered(own, "k3", "k2", _AT_M)
    return cubic | ({("nh", None): 3.0} if cubic else {})


def _creep(own: Own, truth: Mapping[str, Any], place: int | None) -> Numbers:
    # a Kelvin element in line with a spring is a Zener element beside one: k gives way to k / (1 + share)
    more = 1 + own["share"]
    beside: Numbers = {("km", j + 1): k * own["share"] / more for j, k in enumerate(truth["k"])}
    return {**beside, ("tau", None): own["tau"] / more}


def _capstan(own: Own, truth: Mapping[str, Any], place: int | None) -> Numbers:
    return {("mu", j + 1): own["mu"] for j in range(len(truth["k"]))}


def _one(name: str, here: str, less: float = 0.0) -> Callable[[Own, Mapping[str, Any], int | None], Numbers]:
    """The number `name` less what it is without an effect, as the term `here` of its place."""
    return lambda own, truth, place: {(here, place): own[name] - less}


def _all(name: str, here: str) -> Callable[[Own, Mapping[str, Any], int | None], Numbers]:
    """The number `name` as a term that is one for the whole arm."""
    return lambda own, truth, place: {(here, None): own[name]}


_EXPECTED: dict[str, Callable[[Own, Mapping[str, Any], int | None], Numbers]] = {
    "cable_hardening": _hardening,
    "cable_creep": _creep,
    "stribeck_friction": lambda own, truth, place: _numbered(own, "fb", "fst") | {("vs", None): own["vs"]},
    "viscous_friction": lambda own, truth, place: _numbered(own, "fv", "fv"),
    "pulley_friction": _capstan,
    "base_tilt": _all("tilt", "tilt"),
    "tip_payload": _all("mass", "m"),
    "pulley_radius": _one("off", "r"),
    "drum_radius": _one("factor", "rd", less=1.0),
    "spring_stiffness": _one("factor", "ks", less=1.0),
    "marker_offset": _one("offset", "turn"),
    "backlash": _one("play", "play"),
    "actuator_lag": _all("tau", "taul"),
    "actuator_gain": _one("written_over_true", "g", less=1.0),
    "actuator_offset": _one("written_less_true", "fo"),
}
