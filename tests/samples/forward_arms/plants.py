"""Plants, states and settings that tests of the second generator share."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from mechanism.arm import Arm as ReadArm
from mechanism.arm import arm_of
from mechanism.description import read_neck
from samples.forward_arms.cables import lengths
from samples.forward_arms.drawing import drawn, neck
from samples.forward_arms.forward import System
from samples.forward_arms.joints import folded
from samples.forward_arms.plant import Plant
from samples.forward_arms.settings import Settings

Array = NDArray[np.float64]
ODD_ROUTES = (
    ("left",),
    ("strut_mirrored", "left"),
    ("right_through", "right"),
    ("left_through", "strut_mirrored", "left"),
    ("strut", "right_through", "right"),
)
SHORT = Settings(base="exact", seconds=3.6, step=1e-3, recordings=1, offset=(-0.1, 0.1))


def odd_plant(n: int = 3, base: str = "exact", seed: int = 5) -> Plant:
    """Unlike mechanisms with cables on every kind of route."""
    routes = tuple(r for r in ODD_ROUTES if len(r) <= n)
    settings = Settings(mechanisms=n, unlike=True, routes=routes, base="exact")
    made = drawn(settings, seed)
    changed = {"near": {"hyperbola": np.ones(made.M)}, "presliding": {"presliding": np.full(made.M, 0.05)}}
    return replace(made, **changed.get(base, {}))


def any_state(system: System, seed: int = 0) -> Array:
    """All angles and speeds unlike, cables taut or nearly so."""
    rng = np.random.default_rng(seed)
    y = np.zeros((system.size, system.plant.L.shape[1]))
    for rows, size in ((system.alpha, 0.6), (system.alpha_d, 4.0), (system.theta_d, 60.0), (system.bend, 0.9)):
        y[rows] = rng.uniform(-size, size, y[rows].shape)
    alpha = y[system.alpha]
    plant = system.plant
    wound = lengths(plant, folded(plant, alpha), alpha) - system.straight
    y[system.theta] = (rng.uniform(2e-3, 8e-3, wound.shape) - wound - plant.x0) / plant.travel
    return y


def read_arm(plant: Plant, folder: Path) -> ReadArm:
    (folder / "neck.yaml").write_text(yaml.safe_dump(neck(plant)), encoding="utf-8")
    return arm_of(read_neck(folder / "neck.yaml"))
