"""An arm drawn at random, and what its engineer believes of it."""

import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from samples.generator.taut_string import Array

_SAMPLE = Path(__file__).parents[2] / "recording/neck.yaml"
_SCALES = (0.85, 1.2)
_K = np.array([10e3, 9e3, 8e3, 5.5e3])
_RD_SHARE, _X0_SHARE = 0.2, 10.0
"""of the error of drums and of pre-elongations in that of the other dimensions: drums are turned, x0 is hardly known"""

_SIZES = ("L", "b", "r")
_PARTS = (("diagonal", "mass"), ("diagonal", "inertia"), ("top", "mass"), ("top", "inertia"))
_SPRINGS = (("springs", "stiffness"), ("springs", "free_length"))


@dataclass(frozen=True)
class Arm:
    """What is true before any effect: dry friction, linear cables with a damper, commands that act a little late."""

    neck: dict[str, Any]
    k: Array
    """(M,), N/m"""
    ca: Array
    """N s/m"""
    fs: Array
    """N"""
    sharpness: float
    """of the friction where motors turn round, s/rad"""
    delay_s: float
    """from the log's row until the force acts"""


def random_arm(rng: np.random.Generator) -> Arm:
    """The sample's mechanisms and routes; sizes, masses, springs, motors, cables and friction drawn."""
    neck: dict[str, Any] = yaml.safe_load(_SAMPLE.read_text(encoding="utf-8"))
    _scale(neck, lambda _: rng.uniform(*_SCALES))
    for motor in neck["motors"]:
        motor["R"] = round(motor["R"] * rng.uniform(*_SCALES), 2)  # of a gear this is known exactly
    k = _K * rng.uniform(0.7, 1.3, 4)
    for cable, pretension, stiffness in zip(neck["cables"], rng.uniform(2, 30, 4), k, strict=True):
        cable["x0"] = float(pretension / stiffness)
    return Arm(
        neck,
        k,
        ca=rng.uniform(20, 120, 4),
        fs=rng.uniform(10, 20, 4),
        sharpness=float(rng.uniform(0.3, 0.8)),
        delay_s=float(rng.uniform(0, 2e-3)),
    )


def described(neck: dict[str, Any], cad: float, rng: np.random.Generator) -> dict[str, Any]:
    """The arm as drawn in CAD: relative errors of up to `cad`, less of drums and more of x0."""
    said = copy.deepcopy(neck)
    _scale(said, lambda key: 1 + cad * (_RD_SHARE if key == "rd" else 1.0) * rng.uniform(-1, 1))
    for cable in said["cables"]:
        cable["x0"] *= float(1 + _X0_SHARE * cad * rng.uniform(-1, 1))
    return said


def _scale(neck: dict[str, Any], factor: Any) -> None:
    """Multiplies sizes, masses, springs and motors in place, each with a factor of its own: factor(key)."""
    for mechanism in neck["mechanisms"]:
        for key in _SIZES:
            mechanism[key] *= float(factor(key))
        for part, key in (*_PARTS, *_SPRINGS):
            mechanism[part][key] *= float(factor(key))
    for motor in neck["motors"]:
        for key in ("rd", "Ia"):
            motor[key] *= float(factor(key))
