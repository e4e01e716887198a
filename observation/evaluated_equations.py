"""The traced equations of motion as a function of numbers."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from observation.equations import Equations
from observation.generated_code import python_function
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EvaluatedRates:
    """The equations at one state, under one force."""

    mass: Array
    """M(alpha), (N, N), kg m^2"""
    rates: Array
    """torques on the joints (N), N m, theta'' (M), rad/s^2, and rates of the cables' memory variables (M S)"""
    by_state: Array
    """derivatives of the rates by the state, (N + M + M S, size)"""
    tension: Array
    """(M,), N"""
    elongation_d: Array
    """rates of the cables' elongations, (M,), m/s"""
    held: Array
    """square of the torque by which dry friction may hold each joint otherwise than its law says, (N,), N^2 m^2"""


class EvaluatedEquations:
    """Compiles the equations once, to be evaluated row by row."""

    def __init__(self, equations: Equations) -> None:
        layout, e = equations.layout, equations
        self.layout = layout
        self._function = python_function(
            [[v.name for v in e.state], [v.name for v in e.force], [e.time.name]], e.outputs
        )
        counts = [layout.N**2, len(e.rates), len(e.derivatives), layout.M, layout.M, layout.N]
        self._parts = [slice(a, b) for a, b in pairwise(np.cumsum([0, *counts]))]
        rows, columns = np.array(e.places).T
        self._flat_places = rows * layout.size + columns

    def at(self, state: Array, force: Array, elapsed: float) -> EvaluatedRates:
        """At a state (size,), under acting forces (M,), N, elapsed s after the recording began.

        Raises Refused where a mechanism has no such pose.
        """
        try:
            values = np.array(self._function(state.tolist(), force.tolist(), (elapsed,)))
        except (ArithmeticError, ValueError) as error:  # roots of what is negative
            raise left_range(elapsed) from error
        mass, rates, derivatives, tension, elongation_d, held = [values[part] for part in self._parts]
        by_state = np.zeros((len(rates), self.layout.size))
        by_state.ravel()[self._flat_places] = derivatives
        return EvaluatedRates(
            mass=mass.reshape(self.layout.N, self.layout.N),
            rates=rates,
            by_state=by_state,
            tension=tension,
            elongation_d=elongation_d,
            held=held,
        )


def left_range(time: float) -> Refused:
    """The refusal of a state in which a mechanism has no pose, at a time, s."""
    return Refused(
        "observe",
        f"the arm leaves the range of its mechanisms at {time:.3f} s",
        "is it this arm's model and neck.yaml, and are motors counted from the same zero?",
    )
