"""The numbers of a description in the units that people read, what is alike said once."""

from collections.abc import Sequence
from itertools import groupby
from typing import TypeVar

import numpy as np

from mechanism.description import Mechanism, Motor, Neck, Spring

Part = TypeVar("Part", Mechanism, Motor)

MAX_NAMED = 24
"""cables and markers that are named before the rest is counted"""


def mechanism_lines(neck: Neck) -> list[str]:
    """Lengths, masses and springs of the mechanisms; those that are alike stand together."""
    lines = []
    for label, mechanism in _alike(neck.mechanisms):
        lines += [f"{label}: {_lengths(mechanism)}", f"    {_masses(mechanism)}", f"    {_springs(mechanism)}"]
    return lines


def motor_lines(neck: Neck) -> list[str]:
    """Gears, drums and encoders of the motors; those that are alike stand together."""
    plain = [motor.model_copy(update={"joint": None}) for motor in neck.motors]
    return [line for label, motor in _alike(plain) for line in (f"{label}: {_gear(motor)}", f"    {_log(motor)}")]


def cable_lines(neck: Neck) -> list[str]:
    """One line for each cable: its route and its numbers."""
    lines = [
        f"{j + 1}: {route_text(cable.route)}; {cable.length:.4g} m, {1e6 * cable.section:.3g} mm²"
        + (f", x0 {_mm(cable.x0)}" if cable.x0 else "")
        for j, cable in enumerate(neck.cables[:MAX_NAMED])
    ]
    return [*lines, f"... and {neck.M - MAX_NAMED} more"] if neck.M > MAX_NAMED else lines


def route_text(route: Sequence[str]) -> str:
    """The words of a route, those that follow themselves counted: `2 x strut, right`."""
    runs = [(word, len(list(run))) for word, run in groupby(route)]
    return ", ".join(word if count == 1 else f"{count} x {word}" for word, count in runs)


def marker_lines(neck: Neck) -> list[str]:
    """Dictionary and size of the markers, and where each sits; what angles read while the arm stands straight."""
    read = ", ".join(f"{angle:.3g}" for angle in np.degrees(neck.zero_angles))
    zero = [f"angles read {read} deg while the arm stands straight"] if neck.alpha_zero else []
    if neck.markers is None:
        return ["none: joint angles come from elsewhere", *zero]
    places = [f"{marker.id} on {marker.place}" for marker in neck.markers.on_bars]
    if len(places) > MAX_NAMED:
        places[MAX_NAMED:] = [f"... and {len(places) - MAX_NAMED} more"]
    head = f"{neck.markers.dictionary}, black square {_mm(neck.markers.size)}:"
    return [head, *(f"    {line}" for line in _folded(places)), *zero]


def gravity_line(neck: Neck) -> str:
    """Gravity in the base's frame."""
    x, y = neck.gravity
    aside = f", {abs(x):.4g} to the {'right' if x > 0 else 'left'}" if x else ""
    return f"gravity {abs(y):.4g} m/s² {'up' if y > 0 else 'down'}{aside}"


def _alike(parts: Sequence[Part]) -> list[tuple[str, Part]]:
    """Runs of equal parts: `1`, `2-4`, and one of each."""
    runs: list[tuple[int, int]] = []
    for k, part in enumerate(parts):
        if runs and parts[runs[-1][0]] == part:
            runs[-1] = (runs[-1][0], k)
        else:
            runs.append((k, k))
    return [(f"{a + 1}" if a == b else f"{a + 1}-{b + 1}", parts[a]) for a, b in runs]


def _lengths(m: Mechanism) -> str:
    return f"L {_mm(m.L)}, b {_mm(m.b)}, pulleys r {_mm(m.r)}"


def _masses(m: Mechanism) -> str:
    top = f"top bar {_grams(m.top.mass)}, {_inertia(m.top.inertia)}"
    return f"{top}; diagonals {_grams(m.diagonal.mass)}, {_inertia(m.diagonal.inertia)} each"


def _springs(m: Mechanism) -> str:
    left, right = m.springs.sides
    shorter = "hang loose" if m.springs.slack else "push"
    if left != right:
        return f"spring left {_spring(left)}, right {_spring(right)}; {shorter}"
    return f"springs {_spring(left)}; {shorter} when shorter"


def _spring(spring: Spring) -> str:
    return f"{spring.stiffness:.4g} N/m, free {_mm(spring.free_length)}"


def _gear(motor: Motor) -> str:
    return f"gear R {motor.R:.5g}, drum rd {_mm(motor.rd)}, Ia {_inertia(motor.Ia)}, {motor.counts} counts a turn"


def _log(motor: Motor) -> str:
    way = "winds in" if motor.theta_sign > 0 else "lets out"
    return f"in the log: {motor.theta_scale:.6g} rad and {motor.f_scale:.6g} N a unit; growing theta {way}"


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.5g} mm"


def _grams(kilograms: float) -> str:
    return f"{1e3 * kilograms:.4g} g"


def _inertia(value: float) -> str:
    return f"{1e6 * value:.4g} kg mm²"


def _folded(words: Sequence[str], width: int = 62) -> list[str]:
    """Words with commas between them, on lines of at most about `width` characters."""
    lines = [""]
    for word in words:
        joined = f"{lines[-1]}, {word}" if lines[-1] else word
        if len(joined) <= width:
            lines[-1] = joined
        else:
            lines.append(word)
    return lines
