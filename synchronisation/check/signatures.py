"""Signatures: how each fault of geometry, scale or clock would change the elongations, by finite differences of lengths.

A signature is dx / dsize, (F, M), where the size is the true value less that of neck.yaml, or the observed value less the true one.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from synchronisation.check.observation import ElongationObservation

Array = NDArray[np.float64]

STEP_M, STEP_RAD = 1e-5, 1e-4
"""steps of the finite differences"""


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


def candidates(observation: ElongationObservation) -> Iterator[FaultCandidate]:
    """All faults that last from the first frame to the last."""
    arm = observation.arm
    for i in range(arm.N):
        yield FaultCandidate("marker_offset", f"mechanism {i + 1}", "rad", _by_angles(observation, np.eye(arm.N)[i]))
    for i in range(1, arm.N):
        # a marker of an inner bar enters the angle below it and, turned, the one above it
        yield FaultCandidate(
            "marker_offset", f"bar {i}", "rad", _by_angles(observation, np.eye(arm.N)[i - 1] - np.eye(arm.N)[i])
        )
    for j, cable in enumerate(np.eye(arm.M)):
        yield FaultCandidate("drum_radius", f"cable {j + 1}", "1", -observation.theta * arm.drum * cable)
    yield FaultCandidate("drum_radius", "all", "1", -observation.theta * arm.drum)
    for name, field in (("pulley_radius", "r"), ("diagonal_length", "L"), ("bar_length", "b")):
        for i in range(arm.N):
            yield FaultCandidate(name, f"mechanism {i + 1}", "m", _by_arm(observation, field, np.eye(arm.N)[i]))
        yield FaultCandidate(name, "all", "m", _by_arm(observation, field, np.ones(arm.N)))
    yield FaultCandidate("angle_scale", "all", "1", _by_angles(observation, observation.alpha))
    gamma = np.cumsum(observation.alpha, axis=1)
    tilt = np.diff(np.sin(2 * gamma) / 2, axis=1, prepend=0.0)
    yield FaultCandidate("plane_tilt", "all", "1", _by_angles(observation, tilt))
    yield FaultCandidate("clock_offset", "all", "s", observation.theta_d * arm.drum)


def _by_angles(observation: ElongationObservation, change: Array) -> Array:
    """Signature of observed angles that are off by `change`, (N,) or (F, N), times the size."""
    up, down = (observation.elongation(alpha=observation.alpha + sign * STEP_RAD * change) for sign in (1, -1))
    return (up - down) / (2 * STEP_RAD)


def _by_arm(observation: ElongationObservation, field: str, change: Array) -> Array:
    """Signature of lengths (`field` of the arm) that truly are longer than described by `change`, (N,), times the size."""

    def moved(sign: float) -> Arm:
        return replace(observation.arm, **{field: getattr(observation.arm, field) + sign * STEP_M * change})

    return (observation.elongation(moved(-1)) - observation.elongation(moved(1))) / (2 * STEP_M)
