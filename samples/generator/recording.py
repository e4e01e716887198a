"""One recording: the arm driven through an exciting motion, seen by a camera and logged by a controller."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from samples.generator.clocks import Clocks, clocks, frame_times
from samples.generator.controller import Controller, plan
from samples.generator.motion import RATE_HZ, exciting, with_rest
from samples.generator.motors import dry_and_viscous, linear_cable, motors_of
from samples.generator.mujoco_arm import Load, MujocoArm
from samples.generator.simulation import Run, simulate
from samples.generator.taut_string import Array

STEP_S = 1e-4
_SETTLE_S = 3.0
_TIP_PAYLOAD = Load(payload_kg=0.1)
_REST_S = (0.5, 0.5)
"""after the first and before the last frame"""


@dataclass(frozen=True)
class Hidden:
    """The truth that neck.yaml does not hold; per cable, length M."""

    fs: tuple[float, ...] = (14.0, 17.0, 18.0, 16.0)
    """dry friction, N"""
    fv: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    """viscous friction, N s/rad"""
    k: tuple[float, ...] = (10000.0, 9000.0, 8000.0, 5500.0)
    """cable stiffness, N/m"""
    ca: tuple[float, ...] = (60.0, 60.0, 60.0, 60.0)
    """cable damping, N s/m"""
    load: Load = _TIP_PAYLOAD


@dataclass(frozen=True)
class Recording:
    """What happened; `run.time` counts from the log's first row, and advances with the controller's clock."""

    hidden: Hidden
    run: Run
    log_start_s: float
    """first row, controller's clock"""
    clocks: Clocks
    frame_times: Array
    """shape (F,), s, camera's clock"""

    @property
    def log_time(self) -> Array:
        """Rows of the log, shape (T,), s, controller's clock: whole milliseconds."""
        return np.round(self.log_start_s + self.run.time, 3)

    def alpha_at(self, camera_time: float | Array) -> Array:
        """Joint angles at times of the camera's clock, shape (..., N), rad: Hermite between the controller's ticks."""
        between = CubicHermiteSpline(self.log_time, self.run.alpha, self.run.alpha_d, extrapolate=False)
        return between(self.clocks.log_time(np.asarray(camera_time, dtype=float)))


def record(neck: dict[str, Any], duration: float, seed: list[int], hidden: Hidden | None = None) -> Recording:
    """A recording of `duration` s of video of the arm in a parsed neck.yaml, with what it hides."""
    hidden = hidden or Hidden()
    for_motion, for_clocks = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2))
    times = frame_times(duration, for_clocks)
    two = clocks(times, for_clocks)
    first, last = two.log_time(times[[0, -1]])
    log_start = np.floor((first - for_clocks.uniform(0.2, 0.6)) * 1e3) / 1e3
    tail = for_clocks.uniform(0.2, 0.6)
    before = round((first - log_start + _REST_S[0]) * RATE_HZ)
    moving = last - first - sum(_REST_S)
    after = round((_REST_S[1] + tail) * RATE_HZ)

    motion = with_rest(exciting(neck, moving, for_motion), before, after)
    planned = plan(neck, motion)
    friction = dry_and_viscous(np.array(hidden.fs), np.array(hidden.fv))
    tension = linear_cable(np.array(hidden.k), np.array(hidden.ca))
    run = simulate(
        neck,
        MujocoArm(neck, STEP_S, hidden.load),
        motors_of(neck, friction, tension),
        Controller(neck, planned),
        planned.theta[0],
        ticks=len(motion.time),
        settle_ticks=round(_SETTLE_S * RATE_HZ),
    )
    return Recording(hidden, run, float(log_start), two, times)
