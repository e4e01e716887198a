"""Arms of the second generator in which something is hidden, each with two recordings, for the tests of several files.

They are integrated side by side: all together take little longer than one.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from benchmarks.forward_arm_runs import SETTINGS, SeenArm, seen
from samples.forward_arms.arms import make_arms
from samples.forward_arms.drawing import HYPERBOLA
from samples.forward_arms.laws import (
    Described,
    Hardening,
    JointFriction,
    Law,
    Payload,
    RouteFriction,
    Stribeck,
    Tilt,
)
from samples.forward_arms.outside import Cogging, Loom
from samples.forward_arms.plant import Plant


@dataclass(frozen=True)
class Almost(Law):
    """The friction of an arm whose base is `almost`, in one whose base is exact."""

    def altered(self, plant: Plant) -> Plant:
        return replace(plant, hyperbola=np.full_like(plant.hyperbola, HYPERBOLA["almost"]))


SHORT = replace(SETTINGS, drawing_off=1.0, seconds=24.0)
NOISE_DEG = 0.03
SAME_ARM = 1302
HARDENING = Hardening(np.array([3.9e7, 3.5e7, 4.5e7, 6.9e7]))
COGGING = Cogging(force=1.5, poles=7.0)
STICKING = JointFriction(dry=0.08, width=2e-3)
PAYLOAD, STOP = Payload(mass=0.08), Loom(stiffness=1.5, slack=0.2)
HIDDEN: dict[str, tuple[int, tuple[Law, ...]]] = {
    "nothing": (SAME_ARM, ()),
    "hardening": (SAME_ARM, (HARDENING,)),
    "tilt": (SAME_ARM, (Tilt(0.067),)),
    "joint": (SAME_ARM, (JointFriction(dry=0.0166, width=0.1),)),
    "pulleys": (SAME_ARM, (RouteFriction(np.full(4, 0.01), width=1e-3),)),
    "cogging": (481, (COGGING,)),
    "sticking joints": (482, (STICKING,)),
    "payload beside a stop": (484, (PAYLOAD, STOP)),
    "another curve": (5200, (Almost(),)),
    "another curve with a peak": (5200, (Almost(), Stribeck(peak=3.0, width=12.0))),
    "another pulley": (345304, (Almost(), Described("r", 0, 0.8164))),
}
"""seed of each arm, and what is hidden in it; nothing was set on 5200"""


@cache
def seen_arms() -> dict[str, SeenArm]:
    """Of each name, as its camera has it."""
    arms = make_arms([seed for seed, _ in HIDDEN.values()], SHORT, [laws for _, laws in HIDDEN.values()])
    return {name: seen(arm, SHORT, NOISE_DEG) for name, arm in zip(HIDDEN, arms, strict=True)}
