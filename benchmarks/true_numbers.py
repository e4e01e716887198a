"""The numbers of hidden effects as the diagnosis has them, of arms integrated forward: what its numbers are compared with.

Only where a law's form is that of the diagnosis: its joints' friction turns over otherwise, and has none.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from benchmarks.forward_arm_runs import SeenArm
from diagnosis.diagnose import Diagnosis
from mechanism.laws.hardening import AT_M
from samples.forward_arms.arms import Arm
from samples.forward_arms.laws import (
    ActuatorGain,
    ActuatorLag,
    ActuatorOffset,
    Creep,
    Described,
    Hardening,
    Law,
    Payload,
    Presliding,
    PulleyFriction,
    RouteFriction,
    Stribeck,
    Tilt,
    ViscousFriction,
)

Numbers = Mapping[str, Any]
"""by name: one number, or an array of the numbers at every place"""


def _described(law: Any, arm: Arm) -> tuple[str, Numbers]:
    true, drawn = getattr(arm.plant, law.field), getattr(arm.drawing, law.field)
    return {
        "drum": ("drum_radius", {"rd": true / drawn - 1}),
        "motor_inertia": ("motor_inertia", {"Ia": true / drawn - 1}),
        "r": ("pulley_radius", {"r": true - drawn}),
    }[law.field]


_OF: Mapping[type[Law], Callable[[Any, Arm], tuple[str, Numbers]]] = {
    ViscousFriction: lambda law, arm: ("viscous_friction", {"fv": law.fv}),
    Stribeck: lambda law, arm: ("stribeck_friction", {"fst": np.full(arm.plant.M, law.peak), "vs": law.width}),
    Presliding: lambda law, arm: ("presliding_friction", {"fp": arm.plant.dry, "wp": law.width}),
    PulleyFriction: lambda law, arm: ("pulley_friction", {"mu": np.full(arm.plant.M, law.mu)}),
    RouteFriction: lambda law, arm: ("pulley_friction", {"ma": law.mu}),
    Hardening: lambda law, arm: ("cable_hardening", {"k2": AT_M * law.cubic, "nh": 3.0}),
    Creep: lambda law, arm: ("cable_creep", {"km": law.share * arm.plant.stiffness, "tau": law.time}),
    Payload: lambda law, arm: ("tip_payload", {"m": law.mass}),
    Tilt: lambda law, arm: ("base_tilt", {"tilt": law.angle}),
    Described: _described,
    ActuatorGain: lambda law, arm: ("actuator_gain", {"g": 1 / (1 + law.share) - 1}),
    ActuatorOffset: lambda law, arm: ("actuator_offset", {"fo": -law.force}),
    ActuatorLag: lambda law, arm: ("actuator_lag", {"taul": law.time}),
}


def true_numbers(law: Law, arm: Arm) -> tuple[str, Numbers] | None:
    """Name and numbers of the effect that a law of an arm is; None where its form is another."""
    return _OF[type(law)](law, arm) if type(law) in _OF else None


def compared_numbers(found: Diagnosis, seen: SeenArm) -> Iterator[dict[str, Any]]:
    """Every number of a named cause that was hidden: its name, value, sigma and what is true."""
    true = dict(filter(None, (true_numbers(law, seen.arm) for law in seen.arm.laws)))
    for cause, numbers in zip(found.causes, found.numbers, strict=True):
        for number in numbers:
            of_all = true.get(cause.effect.name, {}).get(number.name)
            if of_all is None:
                continue
            value = of_all[number.index - 1] if number.index and np.ndim(of_all) else of_all
            yield {
                "effect": cause.effect.name,
                "number": number.name,
                "value": number.value,
                "sigma": number.sigma,
                "true": float(value),
            }
