"""Three arms that differ in number of mechanisms, routes and laws, and the forces under which they swing."""

from dataclasses import dataclass

import numpy as np

from mechanism.arm import arm_of
from mechanism.description import Neck, read_neck
from mechanism.machine import Machine
from mechanism.simulation import Motion, State, simulate
from tests.paths import NECK_FILE

ROW_S = 0.002
SAMPLE = read_neck(NECK_FILE)
BASE_LAWS = ("dry_friction", "viscous_friction", "linear_cable")


@dataclass(frozen=True)
class Driven:
    """A machine that begins at rest at joint angles (N,), rad, and the forces of its motors around a mean, N."""

    machine: Machine
    start: np.ndarray
    mean: float
    swing: float

    def forces(self, seconds: float) -> np.ndarray:
        """(T, M), N, of rows ROW_S apart."""
        time = ROW_S * np.arange(round(seconds / ROW_S) + 1)
        rates = np.resize([1.1, 1.7, 1.4, 0.9, 1.25], self.machine.arm.M)
        return self.mean + self.swing * np.sin(2 * np.pi * np.outer(time, rates) + np.arange(self.machine.arm.M))

    def by_xneck(self, seconds: float, max_step: float = 5e-4) -> Motion:
        """The motion by the equations of `mechanism`; at 0.5 ms angles are within 0.1 mrad rms of those at a quarter of it.

        So are those of 10 s at 1 ms of those at 0.5 ms."""
        arm, f = self.machine.arm, self.forces(seconds)
        start = State(self.start, np.zeros(arm.N), np.zeros(arm.M), np.zeros(arm.M))
        return simulate(self.machine, start, ROW_S * np.arange(len(f), dtype=float), f, max_step=max_step)


def _unlike(routes: list[list[str]], mechanisms: int) -> Neck:
    """Mechanisms that differ in everything, springs on the right unlike those on the left, gravity at a slant."""

    def mechanism(i: int) -> dict[str, object]:
        L, b, r = ((0.10, 0.05, 0.005), (0.12, 0.06, 0.006), (0.09, 0.04, 0.004), (0.11, 0.05, 0.0))[i]
        return {
            "L": L,
            "b": b,
            "r": r,
            "diagonal": {"mass": 0.03 + 0.005 * i, "inertia": 2.5e-5},
            "top": {"mass": 0.05 + 0.01 * i, "inertia": 1e-5 * (i + 1), "com": [0.004 - 0.005 * i, 0.006]},
            "springs": {
                "stiffness": 400.0 - 40 * i,
                "free_length": (0.05, 0.09, 0.04, 0.05)[i],
                "slack": i == 1,
                "right": {"stiffness": 350.0, "free_length": (0.05, 0.09, 0.045, 0.05)[i]},
            },
        }

    return Neck.model_validate(
        {
            "xneck": 1,
            "gravity": (1.5, -9.6),
            "mechanisms": tuple(mechanism(i) for i in range(mechanisms)),
            "cables": tuple({"route": tuple(route), "length": 1.0, "section": 1e-6, "x0": 0.004} for route in routes),
            "motors": tuple({"R": 25.0, "rd": 0.01, "Ia": 5e-6, "counts": 2048} for _ in routes),
        },
        strict=False,
    )


def sample_arm() -> Driven:
    """The sample's, with the base laws."""
    values = {
        "k": np.array([10e3, 9e3, 8e3, 5.5e3]),
        "ca": np.full(4, 60.0),
        "fs": np.array([14.0, 17, 18, 16]),
        "cm": np.array([0.5]),
        "fv": np.full(4, 0.02),
    }
    return Driven(Machine(arm_of(SAMPLE), BASE_LAWS, values), np.array([0.2, -0.15, 0.1]), 40.0, 30.0)


def mirrored_arm() -> Driven:
    """Two mechanisms and three cables on the other sides, motors that are not told what they do, friction in the joints."""
    routes = [["left"], ["strut_mirrored", "left"], ["right_through", "right"]]
    values = {
        "k": np.full(3, 9e3),
        "ca": np.full(3, 200.0),
        "fs": np.array([10.0, 12.0, 9.0]),
        "cm": np.array([0.4]),
        "fv": np.zeros(3),
        "g": np.array([0.05, -0.03, 0.02]),
        "fo": np.array([1.0, -0.5, 0.0]),
        "cj": np.array([0.01, 0.02]),
        "dj": np.array([0.002, 0.001]),
        "vj": np.array([0.1]),
        "nj": np.array([2.0]),
    }
    names = (*BASE_LAWS, "actuator_gain", "actuator_offset", "joint_friction")
    return Driven(Machine(arm_of(_unlike(routes, 2)), names, values), np.array([-0.2, 0.3]), 40.0, 22.0)


def stiffening_arm() -> Driven:
    """Four mechanisms, one without pulleys, and five cables that get stiffer; friction that is larger near rest."""
    routes = [
        ["right"],
        ["strut", "right"],
        ["strut", "strut", "right"],
        ["left_through", "left_through", "left_through", "left"],
        ["strut", "strut", "strut", "right"],
    ]
    values = {
        "k": np.full(5, 8e3),
        "ca": np.full(5, 80.0),
        "fs": np.full(5, 12.0),
        "cm": np.array([0.5]),
        "fv": np.full(5, 0.01),
        "k2": np.full(5, 4e5),
        "nh": np.array([2.5]),
        "fst": np.full(5, 3.0),
        "vs": np.array([15.0]),
        "ns": np.array([2.0]),
    }
    names = (*BASE_LAWS, "cable_hardening", "stribeck_friction")
    return Driven(Machine(arm_of(_unlike(routes, 4)), names, values), np.array([0.1, -0.2, 0.15, 0.1]), 45.0, 20.0)


ARMS = {"sample": sample_arm, "mirrored": mirrored_arm, "stiffening": stiffening_arm}
