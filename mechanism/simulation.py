"""Simulation of arm, elastic cables and motors, under given motor forces or with given motor angles.

    arm     M(alpha) alpha'' + c + g + joint friction = Z t      (44)
    motors  Ia theta'' = (rd/R) (f - friction - t)               (43)
    cables  t by their laws, a cable cannot push                 (53), (57)

A step takes Z, M, c and g where the arm will be in its middle, which errs with the square of the step, and solves for cables,
friction and motors implicitly (rosenbrock.py). Forces are held between samples as a controller holds them. Every state has
leading axes for a batch, so that many parameter sets, or many windows of one recording, run at once.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from mechanism.arm import Array
from mechanism.batch_layout import arm_batch_last, batch_shape, to_batch_last
from mechanism.machine import Machine
from mechanism.rosenbrock import BatchState
from mechanism.time_stepping import GivenAngles, GivenForces, integrate
from xneck_foundation.errors import Refused

MAX_STEP_S = 2e-3
"""s: longest step of a simulation, a row of a log at 500 Hz (docs/thresholds.md)"""
MAX_BATCH_OF_RUNS = 1024
"""simulations that run at once: numbers that a step works on stay in a cache, and there are enough to make up for its calls"""

Progress = Callable[[int], object]


@dataclass(frozen=True)
class State:
    """alpha, alpha_d of shape (..., N), rad and rad/s; theta, theta_d of shape (..., M), rad and rad/s."""

    alpha: Array
    alpha_d: Array
    theta: Array
    theta_d: Array
    memory: Array | None = None
    """memory variables of the cables, (..., M, states); None: all zero"""


@dataclass(frozen=True)
class Motion:
    """States, cable tensions and motor forces over time, axis -2 is time; time of shape (T,), s; tension and f in N."""

    time: Array
    alpha: Array
    alpha_d: Array
    theta: Array
    theta_d: Array
    tension: Array
    f: Array
    """(..., T, M): as it acts, held from each sample on; where angles are given, as a log would say it at each sample"""


def simulate(
    machine: Machine,
    start: State,
    time: Array,
    f: Array,
    max_step: float = MAX_STEP_S,
    progress: Progress = lambda samples: None,
    began: Array | float = 0.0,
) -> Motion:
    """The motion from `start` under motor forces f.

    time: shape (T,), s, increasing. f: shape (..., T, M), N, f[k] held from time[k] to time[k + 1]. Batch axes of the
    machine's arm and values, of start and f broadcast. Steps are not longer than `max_step`. `progress` is called
    with the number of samples done since the last call. began: (...,), s, when the recording began, in the same time, for laws
    that follow the time. Raises Refused where the motion leaves the mechanism's range.
    """
    given = (_with_time_axis(machine).acting_force(f, _step(time)),)
    return _simulated(machine, start, time, given, max_step, progress, began)


def simulate_given_angles(
    machine: Machine,
    start: State,
    time: Array,
    theta: tuple[Array, Array, Array],
    max_step: float = MAX_STEP_S,
    progress: Progress = lambda samples: None,
    began: Array | float = 0.0,
) -> Motion:
    """The motion of the arm under the pull of its cables while motors turn as given, and the forces that they need for it.

    theta: angles with two derivatives, each (..., T, M); what `start` says of the motors is not used. Else as `simulate`.
    """
    motion = _simulated(machine, start, time, theta, max_step, progress, began)
    return replace(motion, f=_with_time_axis(machine).commanded_force(motion.f, _step(time)))


def _with_time_axis(machine: Machine) -> Machine:
    """The machine with an axis for time before the last one of its values."""
    return replace(machine, values={name: np.asarray(v)[..., None, :] for name, v in machine.values.items()})


def _step(time: Array) -> float:
    return float(np.mean(np.diff(time)))


def _simulated(
    machine: Machine,
    start: State,
    time: Array,
    given: tuple[Array, ...],
    max_step: float,
    progress: Progress,
    began: Array | float,
) -> Motion:
    """The motion, in batches of at most MAX_BATCH_OF_RUNS; given: f alone, or theta with its derivatives."""
    time, arm, m = np.asarray(time, dtype=float), machine.arm, machine.arm.M
    memory = np.zeros((m, machine.states)) if start.memory is None else start.memory
    shape = np.broadcast_shapes(
        batch_shape(arm, machine.values),
        *(np.shape(values)[:-1] for values in (start.alpha, start.alpha_d, start.theta, start.theta_d)),
        *(np.shape(rows)[:-2] for rows in (memory, *given)),
        np.shape(began),
    )
    count, widths = int(np.prod(shape)), (arm.N, arm.N, m, m, m, m)
    out = np.empty((count, len(time), sum(widths)))
    edges = np.linspace(0, count, max(1, -(-count // MAX_BATCH_OF_RUNS)) + 1).round().astype(int)
    parts = [slice(low, high) for low, high in pairwise(edges.tolist())]
    reported = 0
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        for number, part in enumerate(parts):
            values = {name: to_batch_last(value, shape, part) for name, value in machine.values.items()}
            batch = replace(machine, arm=arm_batch_last(arm, shape, part), values=values)
            rows = [to_batch_last(values, shape, part, own_axes=2) for values in given]
            motors = GivenForces(*rows) if len(rows) == 1 else GivenAngles(*rows)
            samples = integrate(
                batch,
                _batch_state(start, memory, part, shape),
                time,
                motors,
                max_step,
                np.broadcast_to(np.asarray(began, dtype=float), shape).reshape(-1)[part],
            )
            for row, sample in enumerate(samples):
                if not np.all(np.abs(sample[: arm.N]) < np.pi):
                    raise Refused(
                        "simulation",
                        f"the arm leaves the range of its mechanisms at {time[row]:.3f} s",
                        "check forces, start and parameters, or simulate in shorter windows",
                    )
                out[part, row] = sample.T
                done = (number * (len(time) - 1) + row) // len(parts)
                progress(done - reported)
                reported = done
    columns = np.split(out.reshape(*shape, len(time), -1), np.cumsum(widths)[:-1], axis=-1)
    alpha, alpha_d, theta, theta_d, tension, f = columns
    return Motion(time=time, alpha=alpha, alpha_d=alpha_d, theta=theta, theta_d=theta_d, tension=tension, f=f)


def _batch_state(start: State, memory: Array, part: slice, shape: tuple[int, ...]) -> BatchState:
    """A part of the batch's states, in batch layout; memory: the start's (..., M, states)."""
    count = len(range(int(np.prod(shape)))[part])
    alpha, alpha_d, theta, theta_d = (
        np.broadcast_to(to_batch_last(values, shape, part), (np.shape(values)[-1], count))
        for values in (start.alpha, start.alpha_d, start.theta, start.theta_d)
    )
    memory = to_batch_last(memory, shape, part, own_axes=2)
    return BatchState(
        alpha, alpha_d, theta, theta_d, np.moveaxis(np.broadcast_to(memory, (*memory.shape[:2], count)), 1, -1)
    )
