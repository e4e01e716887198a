"""A neck.yaml to fill in: a whole arm with example numbers, and a comment for every key."""

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from mechanism.description import Bar, Cable, LogFormat, Mechanism, Motor, Neck, Springs, Top
from mechanism.printed_markers import BarMarker, Markers
from mechanism.tolerance import Tolerance
from mechanism.usual_routes import usual_routes
from xneck_foundation.yaml_text import flow

DEFAULT_DIAGONAL, DEFAULT_BAR = 0.10, 0.05
"""m, L and b of the example, as the arm of Fasquelle's report has them"""

_HEAD = """\
An arm of tensegrity X-joints, to be filled in. SI units and radians everywhere: m, kg, N, s, rad.
Every number here is an example: put in yours. What stands behind a # may be left out.
What is alike is said once: `&motor` names a group of keys, `*motor` stands for all of it, and
`{<<: *motor, theta_sign: -1}` takes it over but for one key.
"""
_WIDTH = 118
_USUAL_LOG = {"time_column": "time", "time_scale": 1.0}
MOTOR = {
    "R": 25.0,
    "rd": 0.010,
    "Ia": 5.0e-6,
    "counts": 2048,
    "theta_sign": 1,
    "theta_scale": 1.0,
    "f_scale": 1.0,
}
_ROD_KG_PER_M = 0.3
"""mass of a bar of the example by its length"""
_TOLERANCE_OF: dict[type[BaseModel], dict[str, str]] = {
    Mechanism: {"L": "length", "b": "length", "r": "pulley"},
    Bar: {"mass": "mass", "inertia": "inertia"},
    Top: {"mass": "mass", "inertia": "inertia"},
    Springs: {"stiffness": "stiffness", "free_length": "free_length"},
    Motor: {"rd": "drum", "Ia": "motor_inertia"},
    Neck: {"gravity": "tilt"},
    BarMarker: {"angle": "marker_angle"},
}
"""the key of `tolerance` that says how well a number is known"""
_TOLERANCE_TEXT = {"tilt": "0.3 deg", "marker_angle": "0.3 deg"}
_OPTIONAL = {
    Springs: {"right": {"stiffness": 400.0, "free_length": 0.05}},
    Motor: {"fv": 0.005, "joint": "motor1", "theta_column": "theta1", "f_column": "f1"},
    LogFormat: {
        "nanoseconds_column": "nanosec",
        "led_column": "led",
        "separator": ";",
        "decimal": ",",
        "units_row": True,
    },
    BarMarker: {"depth": 0.0, "depth_sigma": 0.001, "diagonal": "A1"},
}
"""examples of keys that are left out"""


@dataclass(frozen=True)
class LogKeys:
    """What a log says of neck.yaml: keys of `log`, and those of each motor."""

    log: Mapping[str, Any]
    motors: Sequence[Mapping[str, Any]]


def neck_template(
    mechanisms: int, cables: int, L: float = DEFAULT_DIAGONAL, b: float = DEFAULT_BAR, logged: LogKeys | None = None
) -> str:
    """neck.yaml of an arm with example numbers, which the strict reader takes as it is; L and b, m, of every mechanism.

    logged: what a log is called, of as many motors as cables. Whether L and b make an X-joint is for the reader to say.
    """
    log, named = (logged.log, logged.motors) if logged else (_USUAL_LOG, [{}] * cables)
    routes = usual_routes(mechanisms, cables)
    lines = [f"# {line}" for line in _HEAD.splitlines()]
    lines += _keys(Neck, {"xneck": 1, "gravity": [0.0, -9.81]}, "")
    lines += ["", *_comment(_said(Neck, "mechanisms"), ""), "mechanisms:"]
    lines += _repeated("mechanism", Mechanism, [_mechanism(L, b)] * mechanisms)
    lines += ["", *_comment(_said(Neck, "cables"), ""), "cables:"]
    first, *others = (_cable(route, L) for route in routes)
    lines += [*_entry(Cable, first, "  "), *(f"  - {flow(cable)}" for cable in others)]
    lines += ["", *_comment(_said(Neck, "motors"), ""), "motors:"]
    lines += _repeated("motor", Motor, [{**MOTOR, **keys} for keys in named])
    lines += ["", *_comment(_said(Neck, "log"), ""), "log:" if log else "log: {}", *_keys(LogFormat, log, "  ")]
    lines += ["", *_comment(_said(Neck, "markers"), ""), "markers:"]
    printed = {"dictionary": "apriltag_36h11", "size": max(_rounded(0.6 * b), 0.002)}
    lines += [*_keys(Markers, printed, "  "), *_comment(_said(Markers, "on_bars"), "  "), "  on_bars:"]
    lines += _entry(BarMarker, _marker(0), "    ")
    lines += [f"    - {flow(_marker(bar))}" for bar in range(1, mechanisms + 1)]
    lines += ["", *_comment(_said(Neck, "alpha_zero"), ""), f"# alpha_zero: {flow([0.0] * mechanisms)}"]
    lines += ["", *_comment(_said(Neck, "tolerance"), ""), "tolerance:"]
    usual = {name: _rounded(value) for name, value in Tolerance().model_dump().items()}
    lines += _keys(Tolerance, usual, "  ")
    return "\n".join(lines) + "\n"


def _mechanism(L: float, b: float) -> dict[str, Any]:
    of_diagonal, of_top = _rounded(_ROD_KG_PER_M * L), _rounded(2 * _ROD_KG_PER_M * b)
    side = max(L**2 - b**2, 0.0) ** 0.5
    return {
        "L": L,
        "b": b,
        "r": _rounded(0.1 * b),
        "diagonal": {"mass": of_diagonal, "inertia": _rounded(of_diagonal * L**2 / 12)},
        "top": {"mass": of_top, "inertia": _rounded(of_top * b**2 / 12), "com": [0.0, 0.0]},
        "springs": {"stiffness": 400.0, "free_length": _rounded(0.6 * side), "slack": False},
    }


def _cable(route: tuple[str, ...], L: float) -> dict[str, Any]:
    return {
        "route": list(route),
        "length": min(_rounded(0.5 + 2 * L * len(route)), 100.0),
        "section": 7.9e-7,
        "x0": 0.0,
    }


def _marker(bar: int) -> dict[str, Any]:
    return {"id": bar, "bar": bar, "at": [0.0, 0.0], "angle": 0.0}


def _repeated(name: str, kind: type[BaseModel], entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """A list of entries that are nearly alike: the first with its comments, the others by its name and what differs."""
    first, *others = entries
    lines = _entry(kind, first, "  ", f" &{name}" if others else "")
    for other in others:
        differs = {key: value for key, value in other.items() if first.get(key) != value}
        lines.append(f"  - {{<<: *{name}, {flow(differs)[1:]}" if differs else f"  - *{name}")
    return lines


def _entry(kind: type[BaseModel], values: Mapping[str, Any], indent: str, anchor: str = "") -> list[str]:
    """The lines of a list's entry below its dash."""
    return [f"{indent}-{anchor}", *_keys(kind, values, indent + "  ")]


def _keys(kind: type[BaseModel], values: Mapping[str, Any], indent: str) -> list[str]:
    """Keys with a comment above each; those that are left out stand behind a # with an example."""
    lines: list[str] = []
    examples = _OPTIONAL.get(kind, {})
    for name, field in kind.model_fields.items():
        if name in values:
            lines += _comment(_said(kind, name), indent)
            if isinstance(values[name], Mapping):
                part = field.annotation
                assert isinstance(part, type)
                assert issubclass(part, BaseModel)
                lines += [f"{indent}{name}:", *_keys(part, values[name], indent + "  ")]
            else:
                lines.append(f"{indent}{name}: {flow(values[name])}")
        elif name in examples:
            lines += _comment(_said(kind, name), indent)
            lines.append(f"{indent}# {name}: {flow(examples[name])}")
    return lines


def _said(kind: type[BaseModel], name: str) -> str:
    """What a key means, and how well it is known unless `tolerance` says otherwise."""
    text = " ".join((kind.model_fields[name].description or "").split())
    key = _TOLERANCE_OF.get(kind, {}).get(name)
    if key is None:
        return text
    usual = _TOLERANCE_TEXT.get(key) or f"{100 * getattr(Tolerance(), key):g} %"
    return f"{text}. Known to {usual} (tolerance: {key})"


def _comment(text: str, indent: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent=f"{indent}# ", subsequent_indent=f"{indent}#   ") if text else []


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")
