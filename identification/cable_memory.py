"""Memory variables of cables (creep, hysteresis, play), integrated along a recorded motion."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechanism.affine_steps import accumulated
from mechanism.laws import CableMotion
from mechanism.machine import Machine

Array = NDArray[np.float64]

_MIN_DECAY = 1e-300
"""of a state over a step: zero times an infinite bound would not be a number"""


def pull_memory(machine: Machine, at: CableMotion, step: float) -> Array:
    """Memory variables, (T, M, states), on which the cables' pull depends: those that only friction depends on are zero."""
    return memory_states(machine, at, step) if cables_remember(machine) else np.zeros((*at.x.shape, machine.states))


def moved_memory(machine: Machine, at: CableMotion, step: float, moved: str, z: Array) -> Array:
    """`pull_memory` where one law's numbers have moved, from what it was before: the others remember the same.

    z: (T, M, states), without those of the moved law where that came last and was not there."""
    part = machine.memory_of(moved)
    if part.start == part.stop:
        return z
    out = np.zeros((*at.x.shape, machine.states))
    out[..., : z.shape[-1]] = z
    out[..., part] = pull_memory(replace(machine, names=(moved,)), at, step)
    return out


def cables_remember(machine: Machine) -> bool:
    """Whether the cables' pull depends on memory variables."""
    return not all(law.remembers_path for law in machine.laws if law.states)


def memory_states(machine: Machine, at: CableMotion, step: float) -> Array:
    """Memory variables (T, M, states) on rows `step` s apart, `memory_start` at the first.

    Every law's drift is affine in its own states, a + b z, so that each step is exact while a and b hold over it,
    but for where a bound is met.
    """
    shape = (*at.x.shape, machine.states)
    if not machine.states:
        return np.zeros(shape)
    a = machine.memory_rate(at, np.zeros(shape))
    b = machine.memory_rate(at, np.ones(shape)) - a
    decay = np.maximum(np.exp(b * step), _MIN_DECAY)
    safe = np.where(np.abs(b) * step > 1e-9, b, 1.0)
    added = a * np.where(np.abs(b) * step > 1e-9, (decay - 1) / safe, step)
    bounds = machine.bounds if np.any(np.isfinite(machine.bounds)) else None
    return accumulated(machine.memory_start, decay[:-1], added[:-1], bounds)
