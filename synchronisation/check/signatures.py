"""What each fault of geometry, scale or clock would do to the elongations: its signature, by finite differences of lengths.

A signature is d x / d size, (F, M); size is what is true less what neck.yaml says, or what is seen less what is true.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from synchronisation.check.observation import Observed

Array = NDArray[np.float64]

STEP_M, STEP_RAD = 1e-5, 1e-4


@dataclass(frozen=True)
class FaultCandidate:
    """A fault at a place with the unit of its size; `when` is log time, s, of faults that happen at one moment."""

    fault: str
    where: str
    unit: str
    signature: Array
    when: float | None = None


def candidates(seen: Observed) -> Iterator[FaultCandidate]:
    """All faults that last from the first frame to the last."""
    arm = seen.arm
    for i in range(arm.N):
        yield FaultCandidate("marker_offset", f"mechanism {i + 1}", "rad", _by_angles(seen, np.eye(arm.N)[i]))
    for i in range(1, arm.N):
        # a marker of an inner bar enters the angle below it and, turned, the one above it
        yield FaultCandidate(
            "marker_offset", f"bar {i}", "rad", _by_angles(seen, np.eye(arm.N)[i - 1] - np.eye(arm.N)[i])
        )
    for j, own in enumerate(np.eye(arm.M)):
        yield FaultCandidate("drum_radius", f"cable {j + 1}", "1", -seen.theta * arm.drum * own)
    yield FaultCandidate("drum_radius", "all", "1", -seen.theta * arm.drum)
    for name, field in (("pulley_radius", "r"), ("diagonal_length", "L"), ("bar_length", "b")):
        for i in range(arm.N):
            yield FaultCandidate(name, f"mechanism {i + 1}", "m", _by_arm(seen, field, np.eye(arm.N)[i]))
        yield FaultCandidate(name, "all", "m", _by_arm(seen, field, np.ones(arm.N)))
    yield FaultCandidate("angle_scale", "all", "1", _by_angles(seen, seen.alpha))
    gamma = np.cumsum(seen.alpha, axis=1)
    tilt = np.diff(np.sin(2 * gamma) / 2, axis=1, prepend=0.0)
    yield FaultCandidate("plane_tilt", "all", "1", _by_angles(seen, tilt))
    yield FaultCandidate("clock_offset", "all", "s", seen.theta_d * arm.drum)


def _by_angles(seen: Observed, change: Array) -> Array:
    up, down = (seen.elongation(alpha=seen.alpha + sign * STEP_RAD * change) for sign in (1, -1))
    return (up - down) / (2 * STEP_RAD)


def _by_arm(seen: Observed, field: str, change: Array) -> Array:
    """Of a length that is longer than described: what is computed is then short of the truth."""

    def moved(sign: float) -> Arm:
        return replace(seen.arm, **{field: getattr(seen.arm, field) + sign * STEP_M * change})

    return (seen.elongation(moved(-1)) - seen.elongation(moved(1))) / (2 * STEP_M)
