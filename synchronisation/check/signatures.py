"""Signatures: how each fault of geometry, scale or clock would change the elongations, by finite differences of lengths.

A signature is dx / dsize, (F, M), where the size is the true value less that of neck.yaml, or the observed value less the true one.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from synchronisation.check.observation import ElongationObservation

Array = NDArray[np.float64]

STEP_M, STEP_RAD = 1e-5, 1e-4
"""steps of the finite differences"""
MAX_RELATIVE_SIZE = 0.3
"""share of itself by which a drum, a length or a scale may be off and still be called that (docs/thresholds.md)"""
_NO_SCALES = ("plane_tilt", "clock_offset")
"""faults of the whole recording that are none of an arm's scales"""
_LENGTHS = (("pulley_radius", "r", "pulley"), ("diagonal_length", "L", "length"), ("bar_length", "b", "length"))
"""faults of lengths, the fields of the arm that they are of, and their keys in the tolerance"""


@dataclass(frozen=True)
class FaultCandidate:
    """A fault at a place, before its size is known."""

    fault: str
    where: str
    unit: str
    """of its size"""
    signature: Array
    """(F, M), m for one unit"""
    when: float | None = None
    """log time, s, of a fault that happens at one moment"""
    smallest: float = -np.inf
    """size below which it is not this fault"""
    healthy_unit: float = 1.0
    """size for one unit of what an arm may have and count as healthy, where that is not the unit of the size"""
    largest: float = np.inf
    """size beyond which it is not this fault: what is changed so much is another part, and a signature is of small changes"""

    @property
    def is_scale(self) -> bool:
        """Whether it is one of the scales of drums, lengths and angles, which only their ratios tell."""
        return self.where == "all" and self.fault not in _NO_SCALES


def candidates(observation: ElongationObservation) -> Iterator[FaultCandidate]:
    """All faults that last from the first frame to the last."""
    arm = observation.arm
    for i in range(arm.N):
        yield FaultCandidate("marker_offset", f"mechanism {i + 1}", "rad", _by_angles(observation, np.eye(arm.N)[i]))
    yield from _inner_bars(observation)
    yield from (candidate for candidate, _, _ in _dimensions(observation))
    yield FaultCandidate("drum_radius", "all", "1", -observation.theta * arm.drum, largest=MAX_RELATIVE_SIZE)
    for name, field, _ in _LENGTHS:
        largest = MAX_RELATIVE_SIZE * float(np.min(getattr(arm, field)))
        yield FaultCandidate(name, "all", "m", _by_arm(observation, field, np.ones(arm.N)), largest=largest)
    yield FaultCandidate(
        "angle_scale", "all", "1", _by_angles(observation, observation.adjusted), largest=MAX_RELATIVE_SIZE
    )
    gamma = np.cumsum(observation.adjusted, axis=1)
    tilt = np.diff(np.sin(2 * gamma) / 2, axis=1, prepend=0.0)
    yield FaultCandidate("plane_tilt", "all", "1", _by_angles(observation, tilt), largest=MAX_RELATIVE_SIZE)
    yield FaultCandidate("clock_offset", "all", "s", observation.theta_d * arm.drum)


@lru_cache(maxsize=2)
def tolerated(observation: ElongationObservation) -> tuple[tuple[Array, float], ...]:
    """What neck.yaml and the markers are known to: the signature (F, M) of each number, and its standard deviation above 0.

    Every fit of one observation asks for them: they are kept, and those with an exact drawing beside them.
    """
    joints, tolerance = np.eye(observation.arm.N), observation.tolerance
    of_bars = [_by_angles(observation, joints[0]), *(c.signature for c in _inner_bars(observation))]
    known = [(signature, tolerance.marker_angle) for signature in (*of_bars, _by_angles(observation, -joints[-1]))]
    known += [(c.signature, getattr(tolerance, kind) * described) for c, kind, described in _dimensions(observation)]
    return tuple((signature, sigma) for signature, sigma in known if sigma > 0)


def _inner_bars(observation: ElongationObservation) -> Iterator[FaultCandidate]:
    """A marker of an inner bar enters the angle below it and, turned, the one above it."""
    joints = np.eye(observation.arm.N)
    for i in range(1, observation.arm.N):
        yield FaultCandidate("marker_offset", f"bar {i}", "rad", _by_angles(observation, joints[i - 1] - joints[i]))


def _dimensions(observation: ElongationObservation) -> Iterator[tuple[FaultCandidate, str, float]]:
    """Every drum, pulley radius and length of the arm by itself, with its key in the tolerance and its described value."""
    arm = observation.arm
    for j, cable in enumerate(np.eye(arm.M)):
        signature = -observation.theta * arm.drum * cable
        yield FaultCandidate("drum_radius", f"cable {j + 1}", "1", signature, largest=MAX_RELATIVE_SIZE), "drum", 1.0
    for name, field, kind in _LENGTHS:
        for i in range(arm.N):
            described = float(getattr(arm, field)[i])
            signature = _by_arm(observation, field, np.eye(arm.N)[i])
            largest = MAX_RELATIVE_SIZE * described
            yield FaultCandidate(name, f"mechanism {i + 1}", "m", signature, largest=largest), kind, described


def _by_angles(observation: ElongationObservation, change: Array) -> Array:
    """Signature of observed angles that are off by `change`, (N,) or (F, N), times the size."""
    up, down = (observation.elongation(alpha=observation.adjusted + sign * STEP_RAD * change) for sign in (1, -1))
    return (up - down) / (2 * STEP_RAD)


def _by_arm(observation: ElongationObservation, field: str, change: Array) -> Array:
    """Signature of lengths (`field` of the arm) that truly are longer than described by `change`, (N,), times the size."""

    def moved(sign: float) -> Arm:
        return replace(observation.arm, **{field: getattr(observation.arm, field) + sign * STEP_M * change})

    return (observation.elongation(moved(-1)) - observation.elongation(moved(1))) / (2 * STEP_M)
