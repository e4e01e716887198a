"""Plays many recordings at once: the controller row by row, the arms in fixed steps between."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from samples.forward_arms.controller import Loop, Plan
from samples.forward_arms.forward import Rates, System
from samples.forward_arms.integration import rosenbrock_step
from samples.forward_arms.laws import Law, gathered
from samples.forward_arms.plant import ROW, Array, Plant, side_by_side
from samples.forward_arms.settings import Settings

SETTLING = 0.3
"""s, that arms are at rest before anything sees them"""
_MAX_STEP_ERROR, _HALVINGS = 0.003, 6
"""rad/s by which a step may err in a joint's speed, and how often it is halved at most where it does: friction that turns over
within less than a step's change of speed has arms chatter by 1 rad/s (smooth steps err by .0001)"""


@dataclass(frozen=True)
class Played:
    """Of B recordings, every step from `lead` before the log's begin; the last axis is the recording."""

    time: Array
    """(steps,), s, of the log"""
    alpha: Array
    alpha_d: Array
    alpha_dd: Array
    """(steps, N, B)"""
    theta: Array
    theta_d: Array
    tension: Array
    """(steps, M, B)"""
    row_time: Array
    """(rows,)"""
    counted: Array
    command: Array
    """(rows, M, B)"""


def lead(settings: Settings) -> float:
    """s, before the log begins and after it ends: the camera begins and ends at other times than the log."""
    return SETTLING + max(abs(t) for t in settings.offset)


def row_times(settings: Settings) -> Array:
    """Log times of the controller's rows, s, from `lead` before 0 to `lead` after the log's end."""
    more = lead(settings)
    return np.float64(ROW) * np.arange(-round(more / ROW), round((settings.seconds + more) / ROW))


def play(
    settings: Settings,
    plants: Sequence[Plant],
    laws: Sequence[Sequence[Law]],
    plans: list[Plan],
    seeds: Sequence[Sequence[int]],
) -> Played:
    """One plant, its laws, plan and seed (of the command's jitter) for each recording."""
    system = System(side_by_side(plants), gathered(laws, plants))
    plant, count = system.plant, len(plants)
    loop = Loop(plans)
    rows, per_row = row_times(settings), round(ROW / settings.step)
    if abs(per_row * settings.step - ROW) > 1e-12:
        raise ValueError(f"step = {settings.step} s does not divide the controller's {ROW} s")
    steps = per_row * len(rows)
    of_joints = {name: np.empty((steps, plant.N, count)) for name in ("alpha", "alpha_d", "alpha_dd")}
    of_motors = {name: np.empty((steps, plant.M, count)) for name in ("theta", "theta_d", "tension")}
    counted, commands = (np.empty((len(rows), plant.M, count)) for _ in range(2))
    late_rows = int(settings.delay / ROW + 1e-9)
    late = _lateness(settings, seeds, len(rows), settings.delay - late_rows * ROW)
    y = np.zeros((system.size, count))
    y[system.theta] = np.stack([p.theta for p in plans], axis=-1)
    held = np.zeros((plant.M, count))
    for n, time in enumerate(rows):
        counted[n] = system.encoder(time, y)
        commands[n] = loop.command(n, counted[n])
        coming = commands[max(0, n - late_rows)]
        before = coming if n == 0 else held
        for k in range(per_row):
            # of a step in which the command changes, its mean: no step is cut, and no impulse is lost
            new = np.clip((k + 1) - late[n] / settings.step, 0, 1)
            f = before + new * (coming - before)
            s = n * per_row + k
            begin = y
            y, at = _stepped(system, time + k * settings.step, begin, f, settings.step)
            of_joints["alpha"][s], of_joints["alpha_d"][s] = begin[system.alpha], begin[system.alpha_d]
            of_motors["theta"][s], of_motors["theta_d"][s] = begin[system.theta], begin[system.theta_d]
            of_joints["alpha_dd"][s], of_motors["tension"][s] = at.alpha_dd, at.tension
        held = coming
        if n % 512 == 0 and not np.all(np.isfinite(y)):
            raise FloatingPointError(
                f"recordings {np.flatnonzero(~np.isfinite(y).all(axis=0))} have no state at {time:.3f} s"
            )
    fine = (rows[:, None] + settings.step * np.arange(per_row)).ravel()
    return Played(time=fine, **of_joints, **of_motors, row_time=rows, counted=counted, command=commands)


def _stepped(
    system: System, time: float, begin: Array, f: Array, h: float, halvings: int = _HALVINGS
) -> tuple[Array, Rates]:
    """State after h (s), and the rates at its begin; halves of the step where it errs."""
    y, at, error = rosenbrock_step(system, time, begin, f, h)
    errs = np.any(np.abs(error[system.alpha_d]) > _MAX_STEP_ERROR, axis=0)
    if halvings and np.any(errs):
        middle, _ = _stepped(system, time, begin, f, h / 2, halvings - 1)
        halved, _ = _stepped(system, time + h / 2, middle, f, h / 2, halvings - 1)
        y = np.where(errs, halved, y)
    return y, at


def _lateness(settings: Settings, seeds: Sequence[Sequence[int]], rows: int, delay: float) -> Array:
    """(rows, B), s from a row to its command, within the row."""
    if settings.jitter == 0:
        return np.full((rows, len(seeds)), delay)
    drawn = [np.random.default_rng([*seed, 3]).standard_normal(rows) for seed in seeds]
    return np.clip(delay + settings.jitter * np.stack(drawn, axis=-1), 0, ROW)
