"""A motor whose turning parts are not as described."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from diagnosis.effect import Array, DescriptionEffect, Numbers
from diagnosis.shown_by import MOTOR_ACCELERATION
from mechanism.description import Neck
from mechanism.laws import Term
from mechanism.toleranced_numbers import scaled


class MotorInertia(DescriptionEffect):
    """A motor whose turning parts are not as described."""

    name = "motor_inertia"
    words = "what turns with a motor's shaft is heavier or lighter than described"
    place = "motor"
    shown_by = MOTOR_ACCELERATION
    has_tolerance = True
    terms = (
        Term(
            "Ia",
            "1",
            low=-0.95,
            high=20.0,
            size=0.05,
            would_tell="add up rotor, gear and coupling from their data sheets, and speed every motor up and down fast",
        ),
    )
    order = 12

    def tolerances(self, neck: Neck) -> Array:
        return np.full(neck.M, neck.tolerance.motor_inertia)

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        return scaled("motors", place, ("Ia",))(neck, amount)

    def true_numbers(self, parameters: Mapping[str, float], truth: Mapping[str, Any], place: int | None) -> Numbers:
        """The truth is a factor."""
        return {("Ia", place): parameters["factor"] - 1.0}
