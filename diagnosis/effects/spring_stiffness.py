"""Springs that are not as described."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from diagnosis.effect import Array, DescriptionEffect, Numbers
from diagnosis.shown_by import JOINT_ANGLE
from mechanism.description import Neck
from mechanism.laws import Term
from mechanism.toleranced_numbers import with_springs_apart


class SpringStiffness(DescriptionEffect):
    """Springs that are not as described."""

    name = "spring_stiffness"
    words = "the springs of a mechanism are not as described"
    place = "mechanism"
    part = "springs"
    shown_by = JOINT_ANGLE
    has_tolerance = True
    terms = (
        Term(
            "ks",
            "1",
            low=-0.9,
            high=2.0,
            size=0.02,
            of="joint",
            would_tell="measure the springs, and hold every joint bent by different angles",
        ),
        Term("ku", "1", low=-0.9, high=0.9, size=0.02, of="joint", would_tell="measure the spring on each side"),
    )
    """of both springs, and by how much more the left one and less the right one"""
    order = 12

    def tolerances(self, neck: Neck) -> Array:
        return np.full(2 * neck.N, neck.tolerance.stiffness)

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        term, place = divmod(place, neck.N)
        mechanisms = list(neck.mechanisms)
        mechanism = with_springs_apart(mechanisms[place]) if term else mechanisms[place]
        springs = mechanism.springs
        update: dict[str, object] = {"stiffness": springs.stiffness * (1 + amount)}
        if springs.right is not None:
            opposite = -amount if term else amount
            update["right"] = springs.right.model_copy(update={"stiffness": springs.right.stiffness * (1 + opposite)})
        mechanisms[place] = mechanism.model_copy(update={"springs": springs.model_copy(update=update)})
        return neck.model_copy(update={"mechanisms": tuple(mechanisms)})

    def true_numbers(self, parameters: Mapping[str, float], truth: Mapping[str, Any], place: int | None) -> Numbers:
        """The truth is a factor on both."""
        return {("ks", place): parameters["factor"] - 1.0, ("ku", place): 0.0}
