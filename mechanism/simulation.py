"""The whole in motion: arm, elastic cables and motors under given motor forces, or with motors led along given angles.

    arm     M(alpha) alpha'' + c + g + joint friction = Z t      (44)
    motors  Ia theta'' = (rd/R) (f - friction - t)               (43)
    cables  t by their laws, a cable cannot push                 (53), (57)

A step takes Z, M, c and g where the arm will be in its middle, which errs with the square of the step, and solves for cables,
friction and motors implicitly (stiff_step.py). Forces are held between samples as a controller holds them. Every state has
leading axes for a batch, so that many parameter sets, or many windows of one recording, run at once.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from mechanism.arm import Array
from mechanism.lanes import arm_in_lanes, shape_of, to_lanes
from mechanism.machine import Machine
from mechanism.run import Forced, Led, run
from mechanism.stiff_step import Lanes
from xneck_foundation.errors import Refused

MAX_STEP = 2e-3
"""s, a row of a log at 500 Hz: on the sample's arm and forces alpha is then within 1.2e-5 rad of the exact motion for 0.5 s.
Motors pushed back until all cables go slack and snap taut again cost 2e-3 rad, at a quarter of the step 1e-4"""
LANES = 512
"""at once: what a step works on stays in a cache of 2 MB"""

Progress = Callable[[int], object]


@dataclass(frozen=True)
class State:
    """alpha, alpha_d of shape (..., N), rad and rad/s; theta, theta_d of shape (..., M), rad and rad/s."""

    alpha: Array
    alpha_d: Array
    theta: Array
    theta_d: Array
    memory: Array | None = None
    """what cables remember, (..., M, states); None: nothing yet"""


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
    """as it acts, held from each sample on; of motors that are led, what is written for what they give at each sample"""


def simulate(
    machine: Machine,
    start: State,
    time: Array,
    f: Array,
    max_step: float = MAX_STEP,
    progress: Progress = lambda samples: None,
) -> Motion:
    """The motion from `start` under motor forces f.

    time: shape (T,), s, increasing. f: shape (..., T, M), N, f[k] held from time[k] to time[k + 1]. Batch axes of the
    machine's arm and values, of start and f broadcast. Steps are not longer than `max_step`. `progress` is told of every
    sample done. Raises Refused where the motion leaves the mechanism's range.
    """
    return _moved(machine, start, time, (_over_time(machine).command(f, _step(time)),), max_step, progress)


def follow(
    machine: Machine,
    start: State,
    time: Array,
    theta: tuple[Array, Array, Array],
    max_step: float = MAX_STEP,
    progress: Progress = lambda samples: None,
) -> Motion:
    """The motion of the arm under the pull of its cables while motors turn as given, and the forces that they need for it.

    theta: angles with two derivatives, each (..., T, M); what `start` says of the motors is not used. Else as `simulate`.
    """
    found = _moved(machine, start, time, theta, max_step, progress)
    return replace(found, f=_over_time(machine).written(found.f, _step(time)))


def _over_time(machine: Machine) -> Machine:
    """With an axis for time beside its cables'."""
    return replace(machine, values={name: np.asarray(v)[..., None, :] for name, v in machine.values.items()})


def _step(time: Array) -> float:
    return float(np.mean(np.diff(time)))


def _moved(
    machine: Machine, start: State, time: Array, given: tuple[Array, ...], max_step: float, progress: Progress
) -> Motion:
    """In parts of LANES; given: f alone, or theta with its derivatives."""
    time, arm, m = np.asarray(time, dtype=float), machine.arm, machine.arm.M
    memory = np.zeros((m, machine.states)) if start.memory is None else start.memory
    places = (start.alpha, start.alpha_d, start.theta, start.theta_d)
    shape = np.broadcast_shapes(
        shape_of(arm, machine.values),
        *(np.shape(place)[:-1] for place in places),
        *(np.shape(rows)[:-2] for rows in (memory, *given)),
    )
    count, widths = int(np.prod(shape)), (arm.N, arm.N, m, m, m, m)
    out = np.empty((count, len(time), sum(widths)))
    edges = np.linspace(0, count, max(1, -(-count // LANES)) + 1).round().astype(int)
    parts = [slice(low, high) for low, high in pairwise(edges.tolist())]
    told = 0
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        for number, part in enumerate(parts):
            here = replace(
                machine,
                arm=arm_in_lanes(arm, shape, part),
                values={name: to_lanes(value, shape, part) for name, value in machine.values.items()},
            )
            rows = [to_lanes(values, shape, part, axes=2) for values in given]
            motors = Forced(*rows) if len(rows) == 1 else Led(*rows)
            for row, found in enumerate(run(here, _in_lanes(places, memory, part, shape), time, motors, max_step)):
                if not np.all(np.abs(found[: arm.N]) < np.pi):
                    raise Refused(
                        "simulation",
                        f"the arm leaves the range of its mechanisms at {time[row]:.3f} s",
                        "check forces, start and parameters, or simulate in shorter windows",
                    )
                out[part, row] = found.T
                done = (number * (len(time) - 1) + row) // len(parts)
                progress(done - told)
                told = done
    places_of = np.cumsum(widths)[:-1]
    alpha, alpha_d, theta, theta_d, tension, f = np.split(out.reshape(*shape, len(time), -1), places_of, axis=-1)
    return Motion(time, alpha, alpha_d, theta, theta_d, tension, f)


def _in_lanes(places: tuple[Array, ...], memory: Array, part: slice, shape: tuple[int, ...]) -> Lanes:
    lanes = len(range(int(np.prod(shape)))[part])
    a, a_d, t, t_d = (np.broadcast_to(to_lanes(p, shape, part), (np.shape(p)[-1], lanes)) for p in places)
    remembered = to_lanes(memory, shape, part, axes=2)
    return Lanes(a, a_d, t, t_d, np.moveaxis(np.broadcast_to(remembered, (*remembered.shape[:2], lanes)), 1, -1))
