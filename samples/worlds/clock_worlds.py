"""Recordings of arms drawn at random, for the benchmarks of clocks: what cables, motors and joints do differs from seed to seed.

The distributions were fixed before anything was measured on these seeds.
"""

import copy
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from identification.dataset.series import Series, numbered
from mechanism.arm import Arm, arm_of
from mechanism.description import read_neck
from samples.generator.clocks import Clocks
from samples.generator.laws import cubic, damped, dry_and_viscous, linear, with_creep
from samples.generator.prescribed import World, prescribe
from synchronisation.angles import Angles

Array = NDArray[np.float64]

NECK_FILE = Path(__file__).parents[1] / "recording/neck.yaml"
NOISE = np.radians(0.1)
KINDS = ("linear elastic", "damped cables", "everything")
_K = np.array([10e3, 9e3, 8e3, 5.5e3])


@dataclass(frozen=True)
class Recorded:
    """A recording with its truth; fv (M,), N s/rad."""

    angles: Angles
    log: Series
    clocks: Clocks
    fv: Array
    offset_bound: float
    """Cramér-Rao bound of the offset, s, were angles off by NOISE and all else known but the skew"""


@cache
def arm() -> Arm:
    """The arm as neck.yaml describes it."""
    return arm_of(read_neck(NECK_FILE))


def recorded(kind: str, seed: int, duration: float = 60.0, motion: int | None = None) -> Recorded:
    """A recording of one of KINDS: stiffness and dry friction always differ; `everything` adds to damping motor viscosity,
    stiffening, creep, friction in the joints, and masses and springs that are 1 % off.
    The arm goes with the seed, and so does what it is made to do unless `motion` is another seed for that."""
    rng = np.random.default_rng([seed, 1])
    world, fv = _world(kind, rng)
    hertz = (rng.uniform(0.08, 0.15), rng.uniform(0.9, 1.4))
    moved = seed if motion is None else motion
    made = prescribe(world, duration, moved, hertz)
    alpha = made.frame_alpha + np.random.default_rng([moved, 9]).normal(0, NOISE, made.frame_alpha.shape)
    angles = Angles(made.frame_times, alpha, np.full(alpha.shape, NOISE))
    log = Series(made.log_time, numbered("theta", made.counted) | numbered("f", made.f))
    at = made.clocks.log_time(made.frame_times)
    speed = np.stack([np.interp(at, made.log_time, v) for v in made.alpha_d.T], axis=-1)
    return Recorded(angles, log, made.clocks, fv, offset_bound(made.frame_times, speed))


def offset_bound(time: Array, speed: Array) -> float:
    """Of frames at `time` (F,), s, with joint speeds (F, N), rad/s; the skew, free as well, turns about their middle."""
    about = time - (time[0] + time[-1]) / 2
    square = np.sum(speed**2, axis=1)
    information = np.array([[np.sum(square * about ** (i + j)) for i in (0, 1)] for j in (0, 1)]) / NOISE**2
    return float(np.sqrt(np.linalg.inv(information)[0, 0]))


def _world(kind: str, rng: np.random.Generator) -> tuple[World, Array]:
    neck: dict[str, Any] = yaml.safe_load(NECK_FILE.read_text())
    k, fs, ca = _K * rng.uniform(0.7, 1.3, 4), rng.uniform(10, 20, 4), rng.uniform(20, 120, 4)
    if kind != "everything":
        damping = ca if kind == "damped cables" else np.zeros(4)
        return World(neck, stretch=linear(k, damping), friction=dry_and_viscous(fs, np.zeros(4))), np.zeros(4)
    neck = copy.deepcopy(neck)
    for mechanism in neck["mechanisms"]:
        for part, key in (("diagonal", "mass"), ("top", "mass"), ("springs", "stiffness")):
            mechanism[part][key] *= 1 + 0.01 * rng.normal()
    growth, share, tau = rng.uniform(0.5e4, 2.5e4, 4), rng.uniform(0.03, 0.15), rng.uniform(2, 5)
    rubbing, viscous, width = rng.uniform(0.003, 0.015, 3), rng.uniform(0.001, 0.008, 3), rng.uniform(0.03, 0.08)
    fv = rng.uniform(0.005, 0.03, 4)
    stretch = with_creep(damped(cubic(0.7 * k, 0.7 * k * growth), 6 * k, ca), share / k, tau)
    return World(
        neck,
        stretch=stretch,
        friction=dry_and_viscous(fs, fv),
        joint_friction=lambda speed: rubbing * np.tanh(speed / width) + viscous * speed,
    ), fv


@dataclass(frozen=True)
class Light:
    """A light that changes at random rows of a log: rows, its state in them, brightness per frame."""

    time: Array
    led: Array
    brightness: Array


def light(
    clocks: Clocks,
    frame_times: Array,
    seed: int,
    changes: int = 100,
    exposure: float = 0.004,
    rows: Array | None = None,
) -> Light:
    """Brightness with 2 % of noise, integrated over every exposure in 400 steps; the log's rows are given, or drawn."""
    rng = np.random.default_rng([seed, 3])
    first, last = clocks.log_time(frame_times[[0, -1]])
    drawn = np.floor(1e3 * (first - 0.5)) / 1e3 + 0.002 * np.arange(round((last - first + 1.0) * 500))
    time = drawn if rows is None else rows
    led = np.zeros(len(time))
    led[rng.choice(np.arange(50, len(time) - 50), changes, replace=False)] = 1
    led = np.cumsum(led) % 2
    within = exposure * ((np.arange(400) + 0.5) / 400 - 0.5)
    row = np.searchsorted(time, clocks.log_time(frame_times[:, None] + within), side="right") - 1
    share = led[np.clip(row, 0, len(time) - 1)].mean(axis=1)
    return Light(time, led, 80 + 120 * share + 2.4 * rng.normal(size=len(frame_times)))


def without_trace(recording: Recorded, share: float, seed: int) -> tuple[Angles, Array, NDArray[np.intp]]:
    """The angles with a share of frames lost and stamps that go on evenly; the frames' true times; which frames were lost."""
    rng = np.random.default_rng([seed, 77])
    time = recording.angles.time
    lost = np.flatnonzero(rng.random(len(time)) < share)
    lost = lost[(lost > 20) & (lost < len(time) - 20)]
    kept = np.setdiff1d(np.arange(len(time)), lost)
    stamps = time[kept] - np.searchsorted(lost, kept) / 30
    a = recording.angles
    return Angles(stamps, a.alpha[kept], a.sigma[kept]), time[kept], lost
