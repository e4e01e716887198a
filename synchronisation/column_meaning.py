"""What a column of an unknown log likely is, by its name and its values: time, a motor's angle, its force, and in which unit."""

import re
from dataclasses import dataclass

import numpy as np

from identification.dataset.series import Array
from identification.dataset.time_unit import MIN_MEDIAN_STEP_S, long_units
from synchronisation.column_units import TIME_SCALES, Kind, kind_of_word, unit_of_text, unit_of_word, without_brackets

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
        "elapsed",
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
    "force": {
        "f",
        "force",
        "tau",
        "torque",
        "effort",
        "eff",
        "tension",
        "kraft",
        "moment",
        "load",
        "u",
        "drehmoment",
        "trq",
    },
    "angle": {"theta", "pos", "position", "angle", "q", "enc", "encoder", "phi", "winkel", "th", "rot", "counter"},
    "current": {"current", "curr", "cur", "iq", "strom", "courant"},
    "light": {"led", "light", "lamp", "anchor"},
}
_COMMANDED = {
    "cmd",
    "command",
    "commanded",
    "commands",
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
_UP_TO_SECONDS = ("s", "ms", "us", "ns")
_LONG = {"minutes": "min", "hours": "h", "days": "days"}
_STEP_S = (2e-4, 0.2)
"""s, from row to row of a log that is thought of where the name says no unit of the time"""
_PLACES = {"motor", "axis", "joint", "cable", "seil", "drum", "gear", "side", "left", "right", "raw", "filtered"}
"""words in brackets that are no units"""
_HEADS = ("winkel", "kraft", "moment", "strom", "drehzahl", "geschwindigkeit", "zeit")
"""last parts of German words that say what the whole is: a Motorwinkel is a Winkel"""
_LEVELS = 20


@dataclass(frozen=True)
class Column:
    """One column, or one joint's position or effort."""

    name: str
    kind: Kind
    unit: str | None
    """as its name says, known or not, or its values; None where nothing does"""
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


def column_meaning(name: str, values: Array, kind: Kind | None = None, stated: str = "") -> Column:
    """What a column (T,) likely is. kind: what is known of it already; stated: the unit that stands elsewhere than in its name."""
    finite = values[np.isfinite(values)]
    bare, text = without_brackets(name)
    text = stated or text
    if text and _is_remark(text):
        bare, text = name, ""
    words = _words(bare)
    numbers = [int(word) for word in words if word.isdigit()]
    said = unit_of_text(text) if text else None
    kind = kind or _kind(words, said[1] if said else None, finite)
    unit = _unit(words, text, said, kind)
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
    """Words and numbers in a name, small: `pos_2[deg]` has pos, 2 and deg, `motor2Position` motor, 2 and position,
    `Motorwinkel_1` motor, winkel and 1."""
    units = re.sub(r"(?<![A-Za-z])([mk]?)N([ .*·]?m)?(?![A-Za-z])", lambda u: f"{u[1]}n{'m' if u[2] else ''}", name)
    units = re.sub(r"(?<![A-Za-z])mA(?![A-Za-z])", "ma", units)
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", units)
    compounds = re.sub(rf"(?<=[^\W\d_])({'|'.join(_HEADS)})(?![^\W\d_])", r" \1", parted.lower())
    return re.findall(r"[^\W\d_]+|\d+|°", compounds)


def _kind(words: list[str], of_unit: Kind | None, finite: Array) -> Kind:
    """What words say, but where the unit is one of something else; of_unit: what it is one of, None where that is not known."""
    kinds: tuple[Kind, ...] = ("error", "speed", "light", "force", "angle", "current", "time")
    kind: Kind | None = next((one for one in kinds if _WORDS[one] & set(words)), None)
    if kind in ("error", "speed", "light"):
        return kind
    if of_unit is not None:
        return of_unit
    of_words: set[Kind] = {of for word in words if (of := kind_of_word(word))}
    if "current" in of_words and kind in (None, "force"):
        return "current"
    if kind is not None:
        return kind
    if "i" in words and any(word.isdigit() for word in words):
        return "current"
    if len(of_words) == 1:
        return of_words.pop()
    rising = len(finite) > 1 and bool(np.all(np.diff(finite) > 0))
    return "time" if rising and words[:1] in (["s"], ["sec"], ["ms"], ["us"], ["ns"]) else "other"


def _is_remark(text: str) -> bool:
    """Whether a text that might be a unit says something else, such as that a force was measured."""
    known = set().union(*_WORDS.values(), _COMMANDED, _MEASURED, _PLACES)
    return unit_of_text(text) is None and any(len(word) > 2 and word in known for word in _words(text))


def _unit(words: list[str], text: str, said: tuple[str, Kind] | None, kind: Kind) -> str | None:
    """The unit of a column of some kind, as it is called here, or as it stands there where it is not known."""
    if said is not None:
        return said[0] if said[1] == kind else None
    if text and kind in ("angle", "force", "current"):
        return text
    backwards = [word for word in reversed(words) if not word.isdigit()]
    # a letter before the last word is a name: winch_a_force is not in amperes
    told = [word for place, word in enumerate(backwards) if len(word) > 1 or place == 0]
    return next((unit for word in told if (unit := unit_of_word(word, kind))), None)


def _is_counts(finite: Array) -> bool:
    """Whole numbers, many different ones: no angle in rad, degrees or turns is that."""
    return bool(len(finite) and np.all(finite == np.rint(finite)) and len(np.unique(finite[:20_000])) > _LEVELS)


def _time_unit(finite: Array) -> str | None:
    """The unit of a time by its step, which a log's is 0.2 to 200 ms of; None where two would do, or none.

    Where most rows have the time of the one before, the mean step is theirs: seconds that are whole grow by one, in no row."""
    steps = np.diff(finite)
    growing = steps[steps > 0]
    if not len(growing):
        return None
    step = float(np.median(growing) if 2 * len(growing) > len(steps) else np.mean(steps))
    fitting = [unit for unit in _UP_TO_SECONDS if _STEP_S[0] <= step * TIME_SCALES[unit] <= _STEP_S[1]]
    if max(step, float(np.mean(growing))) < MIN_MEDIAN_STEP_S:
        fitting = [_LONG[name] for name, _ in long_units(step)]
    return fitting[0] if len(fitting) == 1 else None
