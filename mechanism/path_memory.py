"""Memory that friction has of the path of its motor's angle, step by step along the path.

A step moves a memory variable z at its start to `decay` z + `added` at its end, and to `mean_decay` z + `mean_added` in the mean
over the step: all four depend on the step's travel alone, not on how fast the motor runs along it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mechanism.affine_steps import accumulated
from mechanism.arm import Array

_TRAVEL_STEP_RAD = 1e-7
"""of the differences by which slopes are formed, further in the direction of the step: turning round is a kink"""


@dataclass(frozen=True)
class PathSteps:
    """What steps along a path do to memory variables, (S, M, states) each."""

    decay: Array
    added: Array
    mean_decay: Array
    mean_added: Array

    def starts(self, first: Array | None = None) -> Array:
        """The variables where each step begins, (S, M, states); first: where the first one does, (M, states), or nothing."""
        return accumulated(np.zeros(self.decay.shape[1:]) if first is None else first, self.decay, self.added)[:-1]

    def means(self, starts: Array) -> Array:
        """The variables in the mean over each step, (S, M, states)."""
        return self.mean_decay * starts + self.mean_added

    def ends(self, starts: Array) -> Array:
        """The variables where each step ends, (S, M, states)."""
        return self.decay * starts + self.added


@dataclass(frozen=True)
class PathMemory:
    """Memory variables in the mean over each step, and slopes that steps have by what they start from and by their travel.

    All (S, M, states).
    """

    mean: Array
    mean_by_start: Array
    mean_by_travel: Array
    """per rad"""
    end_by_start: Array
    end_by_travel: Array
    """per rad"""

    @classmethod
    def along(cls, travel: Array, steps_of: Callable[[Array], PathSteps], first: Array) -> "PathMemory":
        """Along steps of a travel (S, M), rad; steps_of: what steps of a travel do; first: where the first begins, (M, states)."""
        further = np.where(travel < 0, -_TRAVEL_STEP_RAD, _TRAVEL_STEP_RAD)
        steps, moved = steps_of(travel), steps_of(travel + further)
        starts = steps.starts(first)
        mean, end, by = steps.means(starts), steps.ends(starts), further[..., None]
        return cls(
            mean=mean,
            mean_by_start=steps.mean_decay,
            mean_by_travel=(moved.means(starts) - mean) / by,
            end_by_start=steps.decay,
            end_by_travel=(moved.ends(starts) - end) / by,
        )
