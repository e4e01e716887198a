"""What is known of an arm to about a per cent only: small errors of it are no cause, and must not be taken for one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.linearisation import Linearisation, RecordingLinearisation
from mechanism.description import Neck

Array = NDArray[np.float64]

_ABOUT = 0.006
"""standard deviation of a drawing's number, relative: even within 1 %"""
_TURNED = 0.0012
"""of what is turned on a lathe"""
_FIELDS: dict[str, tuple[str, tuple[str, ...], float]] = {
    "L": ("mechanisms", ("L",), _ABOUT),
    "b": ("mechanisms", ("b",), _ABOUT),
    "r": ("mechanisms", ("r",), _ABOUT),
    "top_mass": ("mechanisms", ("top", "mass"), _ABOUT),
    "diagonal_mass": ("mechanisms", ("diagonal", "mass"), _ABOUT),
    "top_inertia": ("mechanisms", ("top", "inertia"), _ABOUT),
    "diagonal_inertia": ("mechanisms", ("diagonal", "inertia"), _ABOUT),
    "spring_stiffness": ("mechanisms", ("springs", "stiffness"), _ABOUT),
    "spring_free_length": ("mechanisms", ("springs", "free_length"), _ABOUT),
    "motor_inertia": ("motors", ("Ia",), _ABOUT),
    "drum": ("motors", ("rd",), _TURNED),
}
"""of Arm: where neck.yaml has it, and how well it is known"""
_LEAST_CLOCK_S = 1e-5
"""of clocks that came without a sigma"""
WALL = 3.4
"""standard deviations beyond which a nuisance does not go: 2 %"""


def nuisances(at: RecordingLinearisation) -> tuple[tuple[str, ...], Array]:
    """Names, and what one sigma of each of the arm's does to the residuals, (C, S, Q)."""
    arm, names, columns = at.signals.arm, [], []
    for field, (group, _, sigma) in _FIELDS.items():
        count = arm.N if group == "mechanisms" else arm.M
        value = getattr(arm, field)
        for i in range(count):
            more = np.where(np.arange(count) == i, 1 + sigma, 1.0)
            columns.append(at.slow.change(arm=replace(arm, **{field: value * more})))
            names.append(f"{field} {i + 1}")
    return tuple(names), np.stack(columns, axis=-1)


@dataclass(frozen=True)
class Errors:
    """Of every recording: what one sigma of each nuisance does, (C, S, Q), and of its own clock, (C, S, 2)."""

    names: tuple[str, ...]
    arm: tuple[Array, ...]
    own: tuple[Array, ...]
    clock: tuple[float, ...]
    """s: sigma of each recording's offset"""
    doubt: tuple[float, ...]
    """and how many of these it may be off where the laws that told it are wrong"""


def errors(at: Linearisation) -> Errors:
    """At a point; nearby they are the same."""
    found = [nuisances(place) for place in at.places]
    clock = tuple(max(place.signals.clock_sigma[0], _LEAST_CLOCK_S) for place in at.places)
    return Errors(
        found[0][0],
        tuple(columns for _, columns in found),
        tuple(of_recording(place, sigma) for place, sigma in zip(at.places, clock, strict=True)),
        clock,
        tuple(max(1.0, p.signals.clock_doubt / sigma) for p, sigma in zip(at.places, clock, strict=True)),
    )


def of_recording(at: RecordingLinearisation, offset: float) -> Array:
    """What one sigma of the recording's own errors does: its clock's offset (s) and skew, (C, S, 2)."""
    s = at.signals
    age = s.time[s.low_pass.kept] - s.time.mean()
    moves = (at.slow.late(offset), at.slow.late(s.clock_sigma[1] * age))
    return np.stack([at.slow.change(turned=move) for move in moves], axis=-1)


def adjusted(neck: Neck, names: Sequence[str], numbers: Array) -> Neck:
    """neck.yaml with its numbers moved by so many sigmas; names as `nuisances` gives them."""
    changed = neck.model_dump()
    for name, number in zip(names, numbers, strict=True):
        field, place = name.rsplit(" ", 1)
        group, path, sigma = _FIELDS[field]
        entry = changed[group][int(place) - 1]
        for key in path[:-1]:
            entry = entry[key]
        entry[path[-1]] *= 1 + sigma * float(number)
    return Neck.model_validate(changed)
