"""Arms with one hidden effect each, at two noises: how often the diagnosis names it.

Arms, motions and noise are those of `clean_arms`, of the second generator; an arm and its motion are the same at both noises. Both
recordings are synchronised, and the first is diagnosed with the second held out. Runs are kept, and go on where they were stopped.

`python -m benchmarks.hidden_by_noise --out FOLDER [--seeds 1003-1006] [--noises 0.02 0.1] [--share 0/2]` makes the runs alone.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.forward_arm_runs import Record, Runs, Scene, SeenArm, main, topic_folder, verdict
from benchmarks.table import Table
from benchmarks.tuned_seeds import FIRST_COUNTED_FORWARD_ARM
from benchmarks.verdict_record import verdict_record
from diagnosis.diagnose import diagnose
from samples.forward_arms.laws import (
    Hardening,
    JointFriction,
    Payload,
    PulleyFriction,
    Stribeck,
    Tilt,
    ViscousFriction,
)

SEEDS = range(FIRST_COUNTED_FORWARD_ARM, FIRST_COUNTED_FORWARD_ARM + 4)
NOISES_DEG = (0.02, 0.1)
HARDENED, HARDENED_AT_M = 0.15, 0.005
"""share of the linear pull that a hardening cable adds, and the elongation at which it does"""

SCENES = (
    Scene("cable_hardening", lambda plant: [Hardening(HARDENED * plant.stiffness / HARDENED_AT_M**2)]),
    Scene("stribeck_friction", lambda plant: [Stribeck(peak=3.0, width=12.0)]),
    Scene("viscous_friction", lambda plant: [ViscousFriction(np.full(plant.M, 0.02))]),
    Scene("pulley_friction", lambda plant: [PulleyFriction(mu=0.02)]),
    Scene("joint_friction", lambda plant: [JointFriction(dry=np.full(plant.N, 0.03), width=0.1)]),
    Scene("base_tilt", lambda plant: [Tilt(float(np.radians(1.0)))]),
    Scene("tip_payload", lambda plant: [Payload(0.06)]),
)
"""named as the diagnosis names the effects"""


def measure(seeds: Sequence[int] = SEEDS, noises: Sequence[float] = NOISES_DEG, folder: Path | None = None) -> Table:
    """Of each effect and noise: how many arms have it named alone, and how many in the set of causes that explain alike.

    Alone: the verdict is `cause`, and the effect is the only one named. In the set: the verdict is `cause` or `ambiguous`, and
    the effect is one of those that are named or indistinguishable from one that is.
    """
    runs = runs_in(folder or topic_folder("hidden_by_noise"), seeds, noises)
    for _ in runs.complete(judged):
        pass
    return table(runs)


def runs_in(folder: Path, seeds: Sequence[int], noises: Sequence[float]) -> Runs:
    """Arms with each effect, kept in a folder."""
    return Runs(folder, SCENES, seeds, noises)


def judged(arm: SeenArm) -> Record:
    """The record of an arm at one noise, ready for JSON."""
    fitted, held_out = (arm.synchronised(i) for i in range(2))
    return verdict_record(diagnose([fitted], [held_out]))


def table(runs: Runs) -> Table:
    """What the runs come to that a folder holds, a row per effect."""
    columns = [f"{what}, {noise:g} deg" for noise in runs.noises for what in ("alone", "in the set", "of")]
    rows = []
    for scene in runs.scenes:
        figures: list[float] = []
        for noise in runs.noises:
            records = runs.done(scene, noise)
            alone, in_set = (sum(f(r, scene.name) for r in records) for f in (named_alone, named_in_set))
            figures += [alone, in_set, len(records)]
        rows.append((scene.name, tuple(figures)))
    seconds = f"{runs.settings.seconds:g} s"
    title = f"One hidden effect, two recordings of {seconds} each: arms in which it is named"
    return Table(title, tuple(columns), tuple(rows), notes=(runs.sources(),))


def named_alone(record: Record, effect: str) -> bool:
    """Whether the verdict is the effect and nothing else."""
    return verdict(record) == "cause" and record["causes"] == [effect]


def named_in_set(record: Record, effect: str) -> bool:
    """Whether the effect is among those that are named or explain as much."""
    return verdict(record) in ("cause", "ambiguous") and any(
        effect in names for names in (record["causes"], *record["sets"])
    )


if __name__ == "__main__":
    sys.exit(main("benchmarks.hidden_by_noise", __doc__ or "", runs_in, judged, (SEEDS, NOISES_DEG), sys.argv[1:]))
