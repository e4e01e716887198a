"""Springs that are not as described."""

from collections.abc import Mapping
from typing import Any

from diagnosis.effect import DescriptionEffect, Numbers
from mechanism.description import Neck
from mechanism.laws import Term


class SpringStiffness(DescriptionEffect):
    """Springs that are not as described."""

    name = "spring_stiffness"
    words = "the springs of a mechanism are not as described"
    place = "mechanism"
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
    )
    order = 12

    def rewritten(self, neck: Neck, place: int, amount: float) -> Neck:
        mechanisms = list(neck.mechanisms)
        mechanism = mechanisms[place]
        mechanisms[place] = mechanism.model_copy(
            update={
                "springs": mechanism.springs.model_copy(
                    update={"stiffness": mechanism.springs.stiffness * (1 + amount)}
                )
            }
        )
        return neck.model_copy(update={"mechanisms": tuple(mechanisms)})

    def true_numbers(self, parameters: Mapping[str, float], truth: Mapping[str, Any], place: int | None) -> Numbers:
        """The truth is a factor."""
        return {("ks", place): parameters["factor"] - 1.0}
