"""Arms of the second generator in which something is hidden, each with two recordings, for the tests of several files.

They are integrated side by side: all together take little longer than one. Some are the same with every commit, others drawn anew.
"""

import os
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from benchmarks.forward_arm_runs import SETTINGS, Scene, SeenArm, seen
from benchmarks.ladder import COUNTED, OUT, RUNG_1, RUNG_2, mixture
from samples.forward_arms.arms import make_arms
from samples.forward_arms.drawing import HYPERBOLA, drawn
from samples.forward_arms.laws import (
    Described,
    HalvedRouteFriction,
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
from tests.commit import commit


@dataclass(frozen=True)
class Almost(Law):
    """The friction of an arm whose base is `almost`, in one whose base is exact."""

    def altered(self, plant: Plant) -> Plant:
        return replace(plant, hyperbola=np.full_like(plant.hyperbola, HYPERBOLA["almost"]))


SHORT = replace(SETTINGS, drawing_off=1.0, seconds=24.0)
NOISE_DEG = 0.03
SAME_ARM = 1302
HARDENING = Hardening(np.array([3.9e7, 3.5e7, 4.5e7, 6.9e7]))
ONE_HARDENING = Hardening(np.array([0.0, 5e7, 0.0, 0.0]))
COGGING = Cogging(force=1.5, poles=7.0)
JOINT_2_RUBS = JointFriction(dry=np.array([0.0, 0.0166, 0.0]), width=0.1)
STICKING = JointFriction(dry=np.full(3, 0.08), width=2e-3)
BESIDE = Payload(mass=0.06, at=0.015)
PAYLOAD, STOP = Payload(mass=0.08), Loom(stiffness=1.5, slack=0.2)
HIDDEN: dict[str, tuple[int, tuple[Law, ...]]] = {
    "nothing": (SAME_ARM, ()),
    "hardening": (SAME_ARM, (HARDENING,)),
    "one cable hardens": (SAME_ARM, (ONE_HARDENING,)),
    "payload off the middle": (SAME_ARM, (BESIDE,)),
    "tilt": (SAME_ARM, (Tilt(0.067),)),
    "joint": (SAME_ARM, (JOINT_2_RUBS,)),
    "pulleys": (SAME_ARM, (RouteFriction(np.full(4, 0.01), width=1e-3),)),
    "pulleys wound in halves": (SAME_ARM, (HalvedRouteFriction(np.full(4, 0.01), width=1e-3),)),
    "cogging": (481, (COGGING,)),
    "sticking joints": (482, (STICKING,)),
    "payload beside a stop": (484, (PAYLOAD, STOP)),
    "another curve with a peak": (5200, (Almost(), Stribeck(peak=3.0, width=12.0))),
    "another pulley": (345304, (Almost(), Described("r", 0, 0.8164))),
}
"""seed of each arm, and what is hidden in it; nothing was set on 5200"""


NOTHING_HIDDEN = 2
ALONE = 6
"""effects of the catalogue that are hidden by themselves, others with every commit"""
MIXED = 3
"""effects at once: of two, both may hardly show"""
SEED_VARIABLE = "XNECK_HIDDEN_SEED"


def commit_seed() -> int:
    """Of this commit, from 10000 on; the first where there is no repository."""
    if given := os.environ.get(SEED_VARIABLE):
        return int(given)
    return 10000 + 100 * (int(commit()[:8], 16) % 10000)


@cache
def scenes_of_commit() -> tuple[tuple[int, Scene], ...]:
    """Seeds of arms that no one has seen, with what is hidden in each."""
    first = commit_seed()
    mixed = Scene("rung3", lambda plant: list(mixture(plant).values())[:MIXED])
    unlisted = next(scene for scene in OUT if scene.name == f"outside_{COUNTED[0]}")
    alone = np.random.default_rng(first).permutation(len(RUNG_2))[:ALONE]
    scenes = [*[RUNG_1] * NOTHING_HIDDEN, *(RUNG_2[i] for i in alone), mixed, unlisted]
    return tuple(enumerate(scenes, first))


def seen_arms() -> dict[str, SeenArm]:
    """Of each name, as its camera has it."""
    return dict(zip(HIDDEN, _all_arms(), strict=False))


def arms_of_commit() -> tuple[SeenArm, ...]:
    """Those of `scenes_of_commit`. Friction is a tenth of the way from the estimator's own curve to another one, so that nothing
    hidden is no inverse crime."""
    return _all_arms()[len(HIDDEN) :]


@cache
def _all_arms() -> tuple[SeenArm, ...]:
    drawn_anew = [(seed, (Almost(), *scene.laws(drawn(SHORT, seed)))) for seed, scene in scenes_of_commit()]
    seeds, laws = zip(*HIDDEN.values(), *drawn_anew, strict=True)
    return tuple(seen(arm, SHORT, NOISE_DEG) for arm in make_arms(seeds, SHORT, laws))
