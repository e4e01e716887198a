"""Recordings of arms drawn at random, as arrays, for tests and benchmarks of clocks, check and state.

What cables, motors and joints do differs from seed to seed. The distributions were fixed before anything was measured on these
seeds.
"""

import copy
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from identification.dataset.series import Series, interpolated, numbered_columns
from mechanism.arm import Arm, arm_of
from mechanism.description import read_neck
from samples.generator.clocks import Clocks
from samples.generator.laws import cubic, damped, dry_and_viscous, linear, with_creep
from samples.generator.prescribed import World, prescribe
from synchronisation.angles import Angles

Array = NDArray[np.float64]

NECK_FILE = Path(__file__).parents[1] / "recording/neck.yaml"
NOISE_RAD = np.radians(0.1)
KINDS = ("linear elastic", "damped cables", "everything")
_K = np.array([10e3, 9e3, 8e3, 5.5e3])


@dataclass(frozen=True)
class ClockRecording:
    """A recording with its truth."""

    angles: Angles
    log: Series
    clocks: Clocks
    """the true clocks"""
    fv: Array
    """(M,), N s/rad: the true viscosity of the motors"""
    offset_bound: float
    """s: Cramér-Rao bound of the offset, were angles off by NOISE_RAD and all else known but the skew"""


@cache
def arm() -> Arm:
    """The arm as neck.yaml describes it."""
    return arm_of(read_neck(NECK_FILE))


def clock_recording(
    kind: str,
    seed: int,
    duration: float = 60.0,
    motion: int | None = None,
    log_hz: float = 500.0,
    frame_hz: float = 30.0,
) -> ClockRecording:
    """A recording of one of KINDS, of `duration` s, of the arm of a seed; its motion is of the same seed, or of `motion`.

    log_hz, frame_hz: rates of log and camera. Stiffness and dry friction differ in all kinds; `everything` has damping, motor
    viscosity, stiffening, creep, friction in the joints, and masses and springs that are 1 % off."""
    rng = np.random.default_rng([seed, 1])
    world, fv = _world(kind, rng)
    hertz = (rng.uniform(0.08, 0.15), rng.uniform(0.9, 1.4))
    motion_seed = seed if motion is None else motion
    made = prescribe(world, duration, motion_seed, hertz, log_hz=log_hz, frame_hz=frame_hz)
    alpha = made.frame_alpha + np.random.default_rng([motion_seed, 9]).normal(0, NOISE_RAD, made.frame_alpha.shape)
    angles = Angles(made.frame_times, alpha, np.full(alpha.shape, NOISE_RAD))
    log = Series(made.log_time, numbered_columns("theta", made.counted) | numbered_columns("f", made.f))
    at = made.clocks.log_time(made.frame_times)
    speed = interpolated(at, made.log_time, made.alpha_d)
    return ClockRecording(angles, log, made.clocks, fv, offset_bound(made.frame_times, speed))


def offset_bound(time: Array, speed: Array) -> float:
    """Cramér-Rao bound of the offset, s, with an unknown skew: frames at `time` (F,), s, with joint speeds (F, N), rad/s."""
    age = time - (time[0] + time[-1]) / 2
    square = np.sum(speed**2, axis=1)
    information = np.array([[np.sum(square * age ** (i + j)) for i in (0, 1)] for j in (0, 1)]) / NOISE_RAD**2
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
class SwitchedLight:
    """A light that changes at random rows of a log."""

    time: Array
    """(T,), s: the log's rows"""
    led: Array
    """(T,): 0 or 1 in each row"""
    brightness: Array
    """(F,): in each frame"""


def switched_light(
    clocks: Clocks,
    frame_times: Array,
    seed: int,
    changes: int = 100,
    exposure: float = 0.004,
    rows: Array | None = None,
) -> SwitchedLight:
    """A light seen with 2 % of noise, summed over each exposure (s) in 400 steps; the log's rows are given (T,), s, or drawn."""
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
    return SwitchedLight(time, led, 80 + 120 * share + 2.4 * rng.normal(size=len(frame_times)))


def with_lost_frames(recording: ClockRecording, share: float, seed: int) -> tuple[Angles, Array, NDArray[np.intp]]:
    """Angles with a share of the frames lost and stamps that go on evenly, the frames' true times, and which frames were lost."""
    rng = np.random.default_rng([seed, 77])
    time = recording.angles.time
    lost = np.flatnonzero(rng.random(len(time)) < share)
    lost = lost[(lost > 20) & (lost < len(time) - 20)]
    kept = np.setdiff1d(np.arange(len(time)), lost)
    stamps = time[kept] - np.searchsorted(lost, kept) / 30
    a = recording.angles
    return Angles(stamps, a.alpha[kept], a.sigma[kept]), time[kept], lost
