"""Arms that differ from their drawing as a workshop makes them: what is said of them with nothing, one, or several things wrong.

Every number of an arm is drawn about its drawing by the tolerances of a workshop, which neck.yaml has as its defaults. Rung 1 hides
nothing, rung 2 one effect, rung 3 three to six, rung 4 one that no catalogue holds beside as many, and `outside` that one alone.
Both recordings are synchronised, and the first is diagnosed with the second held out. Runs are kept, and go on where they were
stopped.

`python -m benchmarks.ladder --out FOLDER [--seeds 1103-1112] [--noises 0.03] [--share 0/2]` makes the runs alone.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.figures.rate import Rate
from benchmarks.forward_arm_runs import SETTINGS, Record, Runs, Scene, SeenArm, main, percent, topic_folder, verdict
from benchmarks.table import Table
from benchmarks.true_numbers import compared_numbers
from benchmarks.verdict_record import verdict_record
from diagnosis.diagnose import diagnose
from diagnosis.noise_excess import ABOVE_NOISE_RATIO
from diagnosis.remainder import MAX_REMAINDER
from samples.forward_arms import outside
from samples.forward_arms.laws import (
    ActuatorGain,
    ActuatorLag,
    ActuatorOffset,
    Creep,
    Described,
    Hardening,
    JointFriction,
    Law,
    Payload,
    Presliding,
    PulleyFriction,
    RouteFriction,
    Stribeck,
    Tilt,
    ViscousFriction,
)
from samples.forward_arms.plant import Array, Plant

SEEDS = range(1103, 1113)
NOISES_DEG = (0.03,)
OFF_DRAWING = replace(SETTINGS, drawing_off=1.0, columns=128)
Drawn = Callable[[Plant, np.random.Generator], Law]
_AT_M = 0.005
"""elongation at which the share of a hardening cable is said"""
_SLIDING_M_S = (3e-4, 3e-3)
"""m/s: within which a cable's friction on a pulley turns over"""


def _one(plant: Plant, rng: np.random.Generator, low: float, high: float) -> Array:
    """Of one motor, either way; the others have none."""
    out = np.zeros(plant.M)
    out[rng.integers(plant.M)] = rng.choice([-1, 1]) * rng.uniform(low, high)
    return out


def _described(field: str, rng: np.random.Generator, places: int, low: float, high: float) -> Described:
    return Described(field, int(rng.integers(places)), float(1 + rng.choice([-1, 1]) * rng.uniform(low, high)))


def _on_pulleys(plant: Plant, rng: np.random.Generator) -> Law:
    """Where the elastic part of a cable is decides which friction its motor feels: either."""
    mu = rng.uniform(0.004, 0.012)
    if rng.random() < 0.5:
        return PulleyFriction(mu)
    return RouteFriction(np.full(plant.M, mu), width=np.exp(rng.uniform(*np.log(_SLIDING_M_S))))


CATALOGUE: Mapping[str, Drawn] = {
    "cable_hardening": lambda p, rng: Hardening(rng.uniform(0.1, 0.3) * p.stiffness / _AT_M**2),
    "stribeck_friction": lambda p, rng: Stribeck(peak=rng.uniform(2.0, 4.0), width=rng.uniform(8.0, 20.0)),
    "presliding_friction": lambda p, rng: Presliding(rng.uniform(0.02, 0.1, p.M)),
    "viscous_friction": lambda p, rng: ViscousFriction(rng.uniform(0.01, 0.04, p.M)),
    "pulley_friction": _on_pulleys,
    "joint_friction": lambda p, rng: JointFriction(dry=np.full(p.N, rng.uniform(0.01, 0.03)), width=0.1),
    "base_tilt": lambda p, rng: Tilt(float(rng.choice([-1, 1]) * np.radians(rng.uniform(2.0, 5.0)))),
    "tip_payload": lambda p, rng: Payload(rng.uniform(0.05, 0.15)),
    "pulley_radius": lambda p, rng: _described("r", rng, p.N, 0.1, 0.2),
    "drum_radius": lambda p, rng: _described("drum", rng, p.M, 0.03, 0.05),
    "motor_inertia": lambda p, rng: _described("motor_inertia", rng, p.M, 0.6, 0.9),
    "actuator_gain": lambda p, rng: ActuatorGain(_one(p, rng, 0.05, 0.12)),
    "actuator_offset": lambda p, rng: ActuatorOffset(_one(p, rng, 1.0, 3.0)),
    "actuator_lag": lambda p, rng: ActuatorLag(rng.uniform(0.01, 0.03)),
    "cable_creep": lambda p, rng: Creep(rng.uniform(0.25, 0.5), rng.uniform(2.0, 6.0)),
}
"""named as the diagnosis names them, in the sizes that the study hides"""
OUTSIDE: Mapping[str, Law] = {
    "cogging": outside.Cogging(1.5, 7.0),
    "tight_place": outside.TightPlace(3.0, 0.5),
    "eccentric_drum": outside.EccentricDrum(0.02),
    "gear_friction": outside.GearFriction(0.08),
    "saturation": outside.Saturation(200.0),
    "loom": outside.Loom(0.4, 0.1),
    "air_drag": outside.AirDrag(0.01),
    "warming_friction": outside.WarmingFriction(4.0, 20.0),
    "torque_ripple": outside.TorqueRipple(0.04, 6.0),
    "fading_gain": outside.FadingGain(0.06, 25.0),
    "stiff_grease": outside.StiffGrease(0.05, 20.0),
    "tight_joint": outside.TightJoint(0.06, 0.1, 0.15),
    "crosstalk": outside.Crosstalk(0.05),
    "pushes": outside.Pushes(0.3),
    "ageing_friction": outside.AgeingFriction(3.0, 0.5),
    "wrong_encoder": outside.WrongEncoder(0.1),
}
SET_ON = (
    "cogging",
    "eccentric_drum",
    "gear_friction",
    "saturation",
    "loom",
    "warming_friction",
    "torque_ripple",
    "tight_joint",
)
"""of those: they may be looked at while something is set; the others are for counting alone"""
COUNTED = tuple(name for name in OUTSIDE if name not in SET_ON)


def drawing_rng(plant: Plant) -> np.random.Generator:
    """Of an arm: the same sizes whenever it is drawn."""
    return np.random.default_rng(np.frombuffer(plant.stiffness.tobytes(), dtype=np.uint32))


def _single(name: str) -> Callable[[Plant], Sequence[Law]]:
    return lambda plant: [CATALOGUE[name](plant, drawing_rng(plant))]


def mixture(plant: Plant) -> dict[str, Law]:
    """Three to six effects of the catalogue, by name."""
    rng = drawing_rng(plant)
    names = rng.choice(list(CATALOGUE), rng.integers(3, 7), replace=False)
    return {str(name): CATALOGUE[name](plant, rng) for name in names}


def mixture_and_another(plant: Plant, names: Sequence[str]) -> list[Law]:
    """A mixture, and one of these effects that no catalogue holds beside it."""
    another = names[int(drawing_rng(plant).integers(len(names)))]
    return [*mixture(plant).values(), OUTSIDE[another]]


RUNG_1 = Scene("rung1")
RUNG_2 = tuple(Scene(f"rung2_{name}", _single(name)) for name in CATALOGUE)
RUNG_3 = Scene("rung3", lambda plant: list(mixture(plant).values()))
RUNG_4 = Scene("rung4", lambda plant: mixture_and_another(plant, COUNTED))
OUT = tuple(Scene(f"outside_{name}", lambda plant, law=law: [law]) for name, law in OUTSIDE.items())
SCENES = (RUNG_1, *RUNG_2, RUNG_3, RUNG_4, *OUT)


def measure(seeds: Sequence[int] = SEEDS, noises: Sequence[float] = NOISES_DEG, folder: Path | None = None) -> Table:
    """Of each scene: arms whose hidden effects are all named, names that are true, and what is left where not fitted.

    What is right is counted among the arms in which something shows. A name that is not of the set of those that explain alike
    counts as false where it was not hidden. With nothing of the catalogue hidden the right verdict is `consistent` on rung 1 and
    `unknown` outside.
    """
    runs = runs_in(folder or topic_folder("ladder"), seeds, noises)
    for _ in runs.complete(judged):
        pass
    return table(runs)


def runs_in(folder: Path, seeds: Sequence[int], noises: Sequence[float]) -> Runs:
    """The ladder's arms, kept in a folder."""
    return Runs(folder, SCENES, seeds, noises, OFF_DRAWING)


def judged(arm: SeenArm) -> Record:
    """The record of an arm at one noise, ready for JSON."""
    fitted, held_out = (arm.synchronised(i) for i in range(2))
    found = diagnose([fitted], [held_out])
    return verdict_record(found) | {
        "remainder_over_floor": [r.ratio for r in found.remainder],
        "numbers": list(compared_numbers(found, arm)),
        "mixture": sorted(mixture(arm.arm.drawing)),
    }


def table(runs: Runs) -> Table:
    """What the runs come to that a folder holds, a row per scene and noise."""
    columns = (
        "arms",
        "shown",
        "right, %",
        "95 % from",
        "to",
        "names",
        "true names, %",
        "left at most 1.5 times noise, %",
        "numbers",
        "within 1 sigma, %",
        "within 2 sigma, %",
    )
    rows = []
    for scene in runs.scenes:
        for noise in runs.noises:
            if records := runs.done(scene, noise):
                rows.append((f"{scene.name}, {noise:g} deg", _row(scene.name, records)))
    seconds = f"{runs.settings.seconds:g} s"
    title = f"Arms off their drawing, two recordings of {seconds} each"
    return Table(title, columns, tuple(rows), notes=(runs.sources(),))


def _row(scene: str, records: Sequence[Record]) -> tuple[float | None, ...]:
    judged = [r for r in records if verdict(r) != "refused"]
    named = [(r, i) for r in judged for i in range(len(r["causes"]))]
    true = [bool(set(r["sets"][i]) & set(hidden_in(scene, r))) for r, i in named]
    small = [max(r["remainder_over_floor"]) <= MAX_REMAINDER for r in judged]
    shown = [r for r in records if shows(scene, r)]
    right = [is_right(scene, r) for r in shown]
    off = [abs(n["value"] - n["true"]) / n["sigma"] for r in judged for n in r["numbers"]]
    return (
        len(records),
        len(shown),
        *percent(Rate(sum(right), len(right))),
        len(named),
        percent(Rate(sum(true), len(true)))[0],
        percent(Rate(sum(small), len(small)))[0],
        len(off),
        *(percent(Rate(sum(o < sigmas for o in off), len(off)))[0] for sigmas in (1.0, 1.96)),
    )


def shows(scene: str, record: Mapping[str, Any]) -> bool:
    """Whether something hidden stands above noise, or was named all the same; true where nothing is hidden."""
    if verdict(record) == "refused" or not hidden_in(scene, record) or record["causes"]:
        return True
    return max(*record["motors_over_floor"], *record["joints_over_floor"]) > ABOVE_NOISE_RATIO


def hidden_in(scene: str, record: Mapping[str, Any]) -> list[str]:
    """Names of the catalogue's effects that a scene hid in the arm of a record."""
    if scene in (RUNG_3.name, RUNG_4.name):
        return record["mixture"]
    rung, _, name = scene.partition("_")
    return [name] if rung == "rung2" else []


def is_right(scene: str, record: Mapping[str, Any]) -> bool:
    """Whether a verdict names all that is hidden, or a set with each of it, and nothing else."""
    said, hidden = verdict(record), hidden_in(scene, record)
    if not hidden:
        return said == ("unknown" if scene.startswith("outside") else "consistent")
    if said not in ("cause", "ambiguous") or len(record["causes"]) != len(hidden):
        return False
    return all(any(name in names for names in record["sets"]) for name in hidden)


if __name__ == "__main__":
    sys.exit(main("benchmarks.ladder", __doc__ or "", runs_in, judged, (SEEDS, NOISES_DEG), sys.argv[1:]))
