"""How far the simulated arm is from the measured one: at its joints, at its tip, and in the pose in which it is furthest."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.simulation.simulated_recording import SimulatedRecording
from mechanism.arm import Arm
from mechanism.geometry import poses

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WorstPose:
    """The moment at which the base model's tip is furthest from the measured one."""

    recording: int
    """of those that were not fitted, from 0"""
    time: float
    """s, log clock"""
    measured: Array
    """joint angles, (N,), rad"""
    before: Array
    """by the base model, (N,), rad"""
    after: Array
    """by the extended model, (N,), rad"""


@dataclass(frozen=True)
class ArmError:
    """RMS of simulated less measured on recordings that were not fitted, by the base model and by the extended one."""

    joints_before: Array
    """(N,), rad"""
    joints_after: Array
    """(N,), rad"""
    joints_noise: Array
    """what a true model would leave, (N,), rad"""
    tip_before: float
    """of the distance between the middles of the top bar, m"""
    tip_after: float
    """m"""
    worst: WorstPose

    @property
    def is_noise(self) -> bool:
        """Whether no joint is further off, by either model, than a true one might be: then neither is told to be better."""
        return bool(np.all(np.maximum(self.joints_before, self.joints_after) < self.joints_noise))

    def as_json(self) -> dict[str, Any]:
        """For the record."""
        rows = zip(self.joints_before.tolist(), self.joints_after.tolist(), self.joints_noise.tolist(), strict=True)
        return {
            "joints": [{"before_rad": b, "after_rad": a, "noise_floor_rad": n} for b, a, n in rows],
            "tip": {"before_m": self.tip_before, "after_m": self.tip_after},
        }


def arm_error(before: Sequence[SimulatedRecording], after: Sequence[SimulatedRecording], arm: Arm) -> ArmError:
    """Of the same windows of the same recordings by both models; arm: as it is described."""
    measured = [s.series.matrix("alpha", "_measured") for s in after]
    angles = [[s.series.matrix("alpha") for s in simulations] for simulations in (before, after)]
    tips = [_tip(arm, alpha) for alpha in measured]
    off = [[np.abs(_tip(arm, alpha) - tip) for alpha, tip in zip(simulated, tips, strict=True)] for simulated in angles]
    k = int(np.argmax([distance.max() for distance in off[0]]))
    row = int(np.argmax(off[0][k]))
    tip_before, tip_after = (float(np.sqrt(np.mean(np.concatenate(distances) ** 2))) for distances in off)
    return ArmError(
        joints_before=_joints(before, "rms", arm.N),
        joints_after=_joints(after, "rms", arm.N),
        joints_noise=_joints(after, "noise_floor", arm.N),
        tip_before=tip_before,
        tip_after=tip_after,
        worst=WorstPose(
            recording=k,
            time=float(after[k].series.time[row]),
            measured=measured[k][row],
            before=angles[0][k][row],
            after=angles[1][k][row],
        ),
    )


def _tip(arm: Arm, alpha: Array) -> NDArray[np.complex128]:
    """The middle of the top bar at angles (T, N), m, x + iy."""
    return poses(arm, alpha).bar_middle[..., -1]


def _joints(simulations: Sequence[SimulatedRecording], measure: str, joints: int) -> Array:
    levels = [
        [getattr(channel, measure) for channel in s.channels if channel.name.startswith("alpha")] for s in simulations
    ]
    return np.sqrt(np.mean(np.square(levels), axis=0)).reshape(joints)
