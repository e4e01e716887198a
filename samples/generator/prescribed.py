"""A recording whose motion is given: what its motors must have done and drawn, exactly, without integrating the arm.

The motion is known as a function of time; joint torques come from `inverse_dynamics`, tensions from them and a level that
rises and falls, elongations from a law, motor angles from elongations and taut strings, forces from all of these. Nothing of
the packages takes part, and 60 s cost about two seconds, where a simulation costs minutes.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

from samples.generator.clocks import FRAME_HZ, Clocks, clocks, frame_times
from samples.generator.inverse_dynamics import joint_torque
from samples.generator.laws import Friction, Running, Stretch, dry_and_viscous, linear
from samples.generator.motion import LEVEL_N, RATE_HZ, Motion, exciting, with_rest
from samples.generator.mujoco_arm import Load
from samples.generator.routes import lengths
from samples.generator.simulation import quantum
from samples.generator.statics import pull_matrix
from samples.generator.taut_string import Array

STEP_S = 1e-3
"""of arm, tensions and cables"""
MOTOR_STEP_S = 2e-4
"""of motors"""
_LEAST_TENSION_N = 4.0
_FORCE_STEP_N = 0.001
_REST_S = 0.5
_DRAWS = 200
_FS, _K, _CA = (14.0, 17.0, 18.0, 16.0), (10000.0, 9000.0, 8000.0, 5500.0), (60.0, 60.0, 60.0, 60.0)


Course = Callable[[Array, float], Array]
"""a series (T, M) sampled every so many s -> another of that shape"""


Slack = Callable[[Array, Array], tuple[Array, Array] | None]
"""tensions (T, M), N, of taut cables and Z (T, N, M), m, every STEP_S -> tensions that make the same torques, and how far
slack cables hang, (T, M), m; or None where this motion allows none"""


def _no_friction(alpha_d: Array) -> Array:
    return np.zeros_like(alpha_d)


def _no_push(time: Array, alpha: Array) -> Array:
    return np.zeros_like(alpha)


def _taut(tension: Array, Z: Array) -> tuple[Array, Array]:
    return tension, np.zeros_like(tension)


def _as_is(values: Array, step: float) -> Array:
    return values


@dataclass(frozen=True)
class World:
    """The arm as it really is. By default: dry friction, linear damped cables, nothing hidden."""

    neck: dict[str, Any]
    """geometry, masses and motors that are true (parsed neck.yaml)"""
    stretch: Stretch = field(default_factory=lambda: linear(np.array(_K), np.array(_CA)))
    friction: Friction = field(default_factory=lambda: dry_and_viscous(np.array(_FS), np.zeros(4)))
    joint_friction: Callable[[Array], Array] = _no_friction
    """joint speeds (T, N), rad/s -> torque against them, N m"""
    push: Callable[[Array, Array], Array] = _no_push
    """s since the log began, (T,), and joint angles (T, N), rad -> torque of what pushes from outside, (T, N), N m"""
    load: Load = field(default_factory=Load)
    slack: Slack = _taut
    gear: Course = _as_is
    """angle of the drum, in rad of the motor -> angle of the motor"""
    encoder: Course = _as_is
    """angle of the motor -> what the log says in its place"""
    written: Course = _as_is
    """true force, N -> what the controller believes it commanded"""
    seen: Callable[[Array], Array] = lambda alpha: alpha
    """joint angles in the frames, (F, N), rad -> what markers on the bars show of them"""


@dataclass(frozen=True)
class Prescribed:
    """What the files hold, and the truth behind it. Rows of the log T, frames F."""

    world: World
    log_time: Array
    """(T,), s, the controller's clock"""
    counted: Array
    """motor angles as the encoders give them, (T, M), rad"""
    f: Array
    """force commands, (T, M), N: what was held from the row on"""
    clocks: Clocks
    frame_times: Array
    """(F,), s, the camera's clock"""
    frame_alpha: Array
    """true angles in the frames, (F, N), rad"""
    frame_seen: Array
    """what markers show of them, without noise"""
    alpha: Array
    """true, at the rows of the log, (T, N), like the following"""
    alpha_d: Array
    alpha_dd: Array
    theta: Array
    tension: Array
    x: Array
    """elongation, (T, M), m; below zero where a cable hangs slack"""


def prescribe(
    world: World,
    duration: float,
    seed: int | list[int],
    hertz: tuple[float, float] = (0.1, 1.2),
    peak_deg: tuple[float, float] = (25.0, 32.0),
    level_n: tuple[float, float] = LEVEL_N,
    log_hz: float = RATE_HZ,
    frame_hz: float = FRAME_HZ,
) -> Prescribed:
    """A recording of `duration` s of frames. Motions are drawn again until no cable comes near to slack unless it is to.

    level_n: mean and swing of the tension level, N. log_hz: whole parts of 5 kHz.
    """
    rng = np.random.default_rng(seed)
    times = frame_times(duration, rng, frame_hz)
    two = clocks(times, rng)
    first, last = two.log_time(times[[0, -1]])
    start = np.floor((first - rng.uniform(0.2, 0.6)) * 1e3) / 1e3
    before = round((first - start + _REST_S) * RATE_HZ)
    after = round((_REST_S + rng.uniform(0.2, 0.6)) * RATE_HZ)
    for _ in range(_DRAWS):
        drawn = exciting(world.neck, last - first - 2 * _REST_S, rng, hertz, peak_deg, level_n)
        motion = with_rest(drawn, before, after)
        made = _made(world, motion, log_hz)
        if made is not None:
            break
    else:
        raise ValueError("no motion was found that suits the cables")
    alpha, at_row, f = made
    row_time = np.arange(len(f)) / log_hz
    log_time = np.round(start + row_time, 3)
    count = quantum(world.neck)
    frame_alpha = make_interp_spline(log_time, at_row["alpha"], k=5)(two.log_time(times))
    return Prescribed(
        world=world,
        log_time=log_time,
        counted=np.round(at_row["read"] / count) * count,
        f=np.round(f / _FORCE_STEP_N) * _FORCE_STEP_N,
        clocks=two,
        frame_times=times,
        frame_alpha=frame_alpha,
        frame_seen=world.seen(frame_alpha),
        alpha=at_row["alpha"],
        alpha_d=alpha.derivative(1)(row_time),
        alpha_dd=alpha.derivative(2)(row_time),
        theta=at_row["theta"],
        tension=at_row["tension"],
        x=at_row["x"],
    )


def _made(world: World, motion: Motion, log_hz: float) -> tuple[Any, dict[str, Array], Array] | None:
    """The motion as a spline, true series at the rows, and the forces held from the rows on; None where this cannot be."""
    neck = world.neck
    spline = make_interp_spline(motion.time, motion.alpha, k=5)
    time = np.arange(round(motion.time[-1] / STEP_S) + 1) * STEP_S
    alpha = spline(time)
    torque = joint_torque(neck, alpha, STEP_S, world.load) + world.joint_friction(spline.derivative(1)(time))
    torque -= world.push(time, alpha)
    level = np.stack([np.interp(time, motion.time, t) for t in motion.tension.T], axis=-1)
    Z = pull_matrix(neck, alpha)
    tension = _tension(Z, torque, level)
    if tension.min() < _LEAST_TENSION_N:
        return None
    loosened = world.slack(tension, Z)
    if loosened is None:
        return None
    tension, hanging = loosened
    x = world.stretch(tension, STEP_S) - hanging
    motors = neck["motors"]
    drum = np.array([m["rd"] / m["R"] for m in motors])
    inertia = np.array([m["Ia"] for m in motors])
    x0 = np.array([c.get("x0", 0.0) for c in neck["cables"]])
    unrolled = lengths(neck, alpha) - lengths(neck, np.zeros_like(alpha[:1]))
    fine = np.arange(round(motion.time[-1] / MOTOR_STEP_S) + 1) * MOTOR_STEP_S
    theta = world.gear(CubicSpline(time, (x - x0 - unrolled) / drum)(fine), MOTOR_STEP_S)
    theta_d = np.gradient(theta, MOTOR_STEP_S, axis=0)
    theta_dd = np.gradient(theta_d, MOTOR_STEP_S, axis=0)
    t = CubicSpline(time, tension)(fine)
    friction = world.friction(Running(fine, spline(fine), theta, theta_d, t))
    force = world.written(t + friction + inertia / drum * theta_dd, MOTOR_STEP_S)
    per_row = round(1 / (log_hz * MOTOR_STEP_S))
    rows = np.arange(0, len(fine), per_row)
    # the drive holds a command for one period: the mean of what the motion wants over it
    held = np.vstack([force, np.repeat(force[-1:], per_row, axis=0)])
    held = np.vstack([(held[:-1] + held[1:]) / 2, held[-1:]])
    summed = np.vstack([np.zeros(force.shape[1]), np.cumsum(held, axis=0)])
    f = (summed[rows + per_row] - summed[rows]) / per_row
    at_row = {"alpha": spline(fine[rows]), "theta": theta[rows], "tension": t[rows]}
    at_row |= {"x": CubicSpline(time, x)(fine[rows]), "read": world.encoder(theta, MOTOR_STEP_S)[rows]}
    return spline, at_row, f


def _tension(Z: Array, torque: Array, level: Array) -> Array:
    """Tensions nearest to `level`, (T, M), N, that make the torques, (T, N), N m."""
    missing = torque - np.einsum("tnm,tm->tn", Z, level)
    across = np.linalg.solve(np.einsum("tnm,tkm->tnk", Z, Z), missing[..., None])[..., 0]
    return level + np.einsum("tnm,tn->tm", Z, across)
