"""Memory variables of cables (creep, hysteresis, play), integrated along a recorded motion."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechanism.affine_steps import accumulated, accumulated_within
from mechanism.laws import CableMotion
from mechanism.machine import Machine

Array = NDArray[np.float64]


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

    Every law's drift is affine in its own states, a + b z, so that each step is exact while a and b hold over it. What is bounded
    forgets nothing, b = 0: it adds up from one bound to the other.
    """
    out = np.empty((*at.x.shape, machine.states))
    if not machine.states:
        return out
    a, start, (low, high) = machine.memory_rate(at, np.zeros_like(out)), machine.memory_start, machine.bounds
    bounded = np.isfinite(high)
    out[..., bounded] = accumulated_within(start[:, bounded], step * a[:-1, :, bounded], low[bounded], high[bounded])
    if not bounded.all():
        b = (machine.memory_rate(at, np.ones_like(out)) - a)[:-1, :, ~bounded]
        decay = np.exp(b * step)
        safe = np.where(np.abs(b) * step > 1e-9, b, 1.0)
        added = a[:-1, :, ~bounded] * np.where(np.abs(b) * step > 1e-9, (decay - 1) / safe, step)
        out[..., ~bounded] = accumulated(start[:, ~bounded], decay, added)
    return out
