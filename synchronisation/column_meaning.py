"""What a column of an unknown log likely is, by its name and its values: time, a motor's angle, its force, and in which unit."""

import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from identification.dataset.series import Array
from identification.dataset.time_unit import MIN_MEDIAN_STEP_S, long_units

Kind = Literal["time", "angle", "force", "speed", "error", "light", "other"]

_WORDS: dict[Kind, set[str]] = {
    "time": {
        "time",
        "t",
        "timestamp",
        "stamp",
        "zeit",
        "temps",
        "clock",
        "seconds",
        "secs",
        "millis",
        "micros",
        "epoch",
        "tick",
    },
    "error": {
        "err",
        "error",
        "offset",
        "off",
        "bias",
        "diff",
        "delta",
        "deviation",
        "fehler",
        "abweichung",
        "residual",
    },
    "speed": {
        "vel",
        "velocity",
        "speed",
        "omega",
        "rpm",
        "qd",
        "qdot",
        "thetad",
        "thetadot",
        "dtheta",
        "dq",
        "dot",
        "dt",
        "ddot",
        "acc",
        "accel",
        "acceleration",
        "geschwindigkeit",
        "drehzahl",
        "rate",
        "v",
        "w",
    },
    "force": {"f", "force", "tau", "torque", "effort", "tension", "kraft", "moment", "load", "u", "drehmoment"},
    "angle": {"theta", "pos", "position", "angle", "q", "enc", "encoder", "phi", "winkel", "th", "rot", "counter"},
    "light": {"led", "light", "lamp", "anchor"},
}
_COMMANDED = {
    "cmd",
    "command",
    "commanded",
    "des",
    "desired",
    "ref",
    "r",
    "sp",
    "wanted",
    "reference",
    "target",
    "set",
    "setpoint",
    "soll",
    "goal",
}
_MEASURED = {"meas", "measured", "act", "actual", "ist", "fb", "feedback", "sensor", "sensed", "gemessen"}
_UNITS: dict[str, tuple[str, set[Kind]]] = {
    "s": ("s", {"time"}),
    "sec": ("s", {"time"}),
    "secs": ("s", {"time"}),
    "seconds": ("s", {"time"}),
    "ms": ("ms", {"time"}),
    "msec": ("ms", {"time"}),
    "millis": ("ms", {"time"}),
    "us": ("us", {"time"}),
    "µs": ("us", {"time"}),
    "micros": ("us", {"time"}),
    "ns": ("ns", {"time"}),
    "nanos": ("ns", {"time"}),
    "min": ("min", {"time"}),
    "minutes": ("min", {"time"}),
    "minuten": ("min", {"time"}),
    "h": ("h", {"time"}),
    "hours": ("h", {"time"}),
    "days": ("days", {"time"}),
    "tage": ("days", {"time"}),
    "rad": ("rad", {"angle"}),
    "radians": ("rad", {"angle"}),
    "mrad": ("mrad", {"angle"}),
    "deg": ("deg", {"angle"}),
    "degree": ("deg", {"angle"}),
    "degrees": ("deg", {"angle"}),
    "°": ("deg", {"angle"}),
    "grad": ("deg", {"angle"}),
    "rev": ("turns", {"angle"}),
    "revs": ("turns", {"angle"}),
    "turn": ("turns", {"angle"}),
    "turns": ("turns", {"angle"}),
    "cnt": ("counts", {"angle"}),
    "count": ("counts", {"angle"}),
    "counts": ("counts", {"angle"}),
    "ticks": ("counts", {"angle"}),
    "inc": ("counts", {"angle"}),
    "n": ("N", {"force"}),
    "mn": ("mN", {"force"}),
    "kn": ("kN", {"force"}),
    "nm": ("N m", {"force"}),
    "mnm": ("mN m", {"force"}),
    "a": ("A", {"force"}),
    "ma": ("mA", {"force"}),
    "amp": ("A", {"force"}),
}
"""units by the words that names hold, and what they are units of"""
TIME_SCALES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "days": 86400.0}
ANGLE_SCALES = {"rad": 1.0, "mrad": 1e-3, "deg": np.pi / 180, "turns": 2 * np.pi}
_UP_TO_SECONDS = ("s", "ms", "us", "ns")
_LONG = {"minutes": "min", "hours": "h", "days": "days"}
_STEP_S = (2e-4, 0.2)
"""s, from row to row of a log that is thought of where the name says no unit of the time"""
_LEVELS = 20


@dataclass(frozen=True)
class Column:
    """One column, or one joint's position or effort."""

    name: str
    kind: Kind
    unit: str | None
    """as its name says, or its values; None where nothing does"""
    unit_by: str
    """`name`, `values`, or nothing"""
    number: int | None
    """of the motor, as its name says"""
    stem: str
    """the name without that number: columns of one stem belong together"""
    commanded: bool
    measured: bool
    """whether its name says so, of those that are not commanded"""
    low: float
    high: float
    missing: int
    """rows without a number"""

    @property
    def constant(self) -> bool:
        """Whether it never changes."""
        return self.low == self.high


def column_meaning(name: str, values: Array, kind: Kind | None = None) -> Column:
    """What a column (T,) likely is. kind: what is known of it already."""
    finite = values[np.isfinite(values)]
    words = _words(name)
    numbers = [int(word) for word in words if word.isdigit()]
    kind = kind or _kind(words, finite)
    unit = next((u for word in reversed(words) for u, of in [_UNITS.get(word, ("", set()))] if kind in of), None)
    by = "name" if unit else ""
    if unit is None and kind == "angle" and _is_counts(finite):
        unit, by = "counts", "values"
    if unit is None and kind == "time":
        unit, by = _time_unit(finite), "values"
    return Column(
        name=name,
        kind=kind,
        unit=unit,
        unit_by=by if unit else "",
        number=numbers[-1] if numbers else None,
        stem=" ".join(word for word in words if not word.isdigit()),
        commanded=bool(_COMMANDED & set(words)),
        measured=bool(_MEASURED & set(words)) and not _COMMANDED & set(words),
        low=float(finite.min(initial=np.inf)) if len(finite) else np.nan,
        high=float(finite.max(initial=-np.inf)) if len(finite) else np.nan,
        missing=len(values) - len(finite),
    )


def _words(name: str) -> list[str]:
    """Words and numbers in a name, small: `pos_2[deg]` has pos, 2 and deg, `motor2Position` motor, 2 and position."""
    units = re.sub(r"(?<![A-Za-z])([mk]?)N([ .*·]?m)?(?![A-Za-z])", lambda u: f"{u[1]}n{'m' if u[2] else ''}", name)
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", units)
    return re.findall(r"[^\W\d_]+|\d+|°", parted.lower())


def _kind(words: list[str], finite: Array) -> Kind:
    kinds: tuple[Kind, ...] = ("error", "speed", "light", "force", "angle", "time")
    for kind in kinds:
        if _WORDS[kind] & set(words):
            return kind
    units: set[Kind] = {of for word in words if word in _UNITS and len(word) > 1 for of in _UNITS[word][1]}
    if len(units) == 1:
        return units.pop()
    rising = len(finite) > 1 and bool(np.all(np.diff(finite) > 0))
    return "time" if rising and words[:1] in (["s"], ["sec"], ["ms"], ["us"], ["ns"]) else "other"


def _is_counts(finite: Array) -> bool:
    """Whole numbers, many different ones: no angle in rad, degrees or turns is that."""
    return bool(len(finite) and np.all(finite == np.rint(finite)) and len(np.unique(finite[:20_000])) > _LEVELS)


def _time_unit(finite: Array) -> str | None:
    """The unit of a time by its step, which a log's is 0.2 to 200 ms of; None where two would do, or none."""
    steps = np.diff(finite)
    steps = steps[steps > 0]
    if not len(steps):
        return None
    step = float(np.median(steps))
    fitting = [unit for unit in _UP_TO_SECONDS if _STEP_S[0] <= step * TIME_SCALES[unit] <= _STEP_S[1]]
    if max(step, float(np.mean(steps))) < MIN_MEDIAN_STEP_S:
        fitting = [_LONG[name] for name, _ in long_units(step)]
    return fitting[0] if len(fitting) == 1 else None
