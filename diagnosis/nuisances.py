"""What is known of an arm to about a per cent only: small errors of it are no cause, and must not be taken for one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.linearisation import Linearisation, RecordingLinearisation
from mechanism.description import Neck
from mechanism.drawing_errors import DRAWING_SIGMA, LATHE_SIGMA

Array = NDArray[np.float64]

_FIELDS: dict[str, tuple[str, tuple[str, ...], float]] = {
    "L": ("mechanisms", ("L",), DRAWING_SIGMA),
    "b": ("mechanisms", ("b",), DRAWING_SIGMA),
    "r": ("mechanisms", ("r",), DRAWING_SIGMA),
    "top_mass": ("mechanisms", ("top", "mass"), DRAWING_SIGMA),
    "diagonal_mass": ("mechanisms", ("diagonal", "mass"), DRAWING_SIGMA),
    "top_inertia": ("mechanisms", ("top", "inertia"), DRAWING_SIGMA),
    "diagonal_inertia": ("mechanisms", ("diagonal", "inertia"), DRAWING_SIGMA),
    "spring_stiffness": ("mechanisms", ("springs", "stiffness"), DRAWING_SIGMA),
    "spring_free_length": ("mechanisms", ("springs", "free_length"), DRAWING_SIGMA),
    "motor_inertia": ("motors", ("Ia",), DRAWING_SIGMA),
    "drum": ("motors", ("rd",), LATHE_SIGMA),
}
"""by field of Arm: where neck.yaml has it, and how well it is known (docs/thresholds.md)"""
_MIN_CLOCK_SIGMA_S = 1e-5
"""s: sigma of clocks that came without one (docs/thresholds.md)"""
NUISANCE_BOUND = 3.4
"""standard deviations beyond which a nuisance does not go: 2 % of a drawing's number (docs/thresholds.md)"""


@dataclass(frozen=True)
class Nuisances:
    """What small errors of the arm and of the clocks do to the residuals."""

    names: tuple[str, ...]
    """the arm's, Q of them"""
    arm_columns: tuple[Array, ...]
    """of each recording: what one sigma of each of the arm's does, (C, S, Q)"""
    clock_columns: tuple[Array, ...]
    """of each recording: what one sigma of its clock's offset and skew does, (C, S, 2)"""
    clock_sigma: tuple[float, ...]
    """s: of each recording's offset"""
    clock_relaxation: tuple[float, ...]
    """factor on each `clock_sigma` where the laws that the clock rests on are wrong"""


def nuisances_at(at: Linearisation) -> Nuisances:
    """At a linearisation; nearby they are the same."""
    arm = [_arm_columns(recording) for recording in at.recordings]
    clock_sigma = tuple(max(r.signals.clock_sigma[0], _MIN_CLOCK_SIGMA_S) for r in at.recordings)
    return Nuisances(
        names=arm[0][0],
        arm_columns=tuple(columns for _, columns in arm),
        clock_columns=tuple(_clock_columns(r, sigma) for r, sigma in zip(at.recordings, clock_sigma, strict=True)),
        clock_sigma=clock_sigma,
        clock_relaxation=tuple(
            max(1.0, r.signals.relaxed_clock_sigma / sigma) for r, sigma in zip(at.recordings, clock_sigma, strict=True)
        ),
    )


def _arm_columns(recording: RecordingLinearisation) -> tuple[tuple[str, ...], Array]:
    """Names, and what one sigma of each of the arm's numbers does to the residuals, (C, S, Q)."""
    arm, names, columns = recording.signals.arm, [], []
    for field, (group, _, sigma) in _FIELDS.items():
        count = arm.N if group == "mechanisms" else arm.M
        value = getattr(arm, field)
        for i in range(count):
            factor = np.where(np.arange(count) == i, 1 + sigma, 1.0)
            columns.append(recording.sensitivity.residual_change(arm=replace(arm, **{field: value * factor})))
            names.append(f"{field} {i + 1}")
    return tuple(names), np.stack(columns, axis=-1)


def _clock_columns(recording: RecordingLinearisation, offset_sigma: float) -> Array:
    """What one sigma of the recording's clock does: its offset's (s) and its skew's, (C, S, 2)."""
    s, sensitivity = recording.signals, recording.sensitivity
    age = s.time[s.low_pass.kept] - s.time.mean()
    shifts = (sensitivity.error_of_lag(offset_sigma), sensitivity.error_of_lag(s.clock_sigma[1] * age))
    return np.stack([sensitivity.residual_change(angle_error=shift) for shift in shifts], axis=-1)


def adjusted(neck: Neck, names: Sequence[str], numbers: Array) -> Neck:
    """neck.yaml with its numbers moved by so many sigmas; names as `Nuisances` has them."""
    changed = neck.model_dump()
    for name, number in zip(names, numbers, strict=True):
        field, place = name.rsplit(" ", 1)
        group, path, sigma = _FIELDS[field]
        entry = changed[group][int(place) - 1]
        for key in path[:-1]:
            entry = entry[key]
        entry[path[-1]] *= 1 + sigma * float(number)
    return Neck.model_validate(changed)
