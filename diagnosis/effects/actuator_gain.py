"""A motor that pulls in another proportion."""

from collections.abc import Mapping
from typing import Any

from diagnosis.effect import LawEffect, Numbers, law_terms
from diagnosis.shown_by import FORCE


class ActuatorGain(LawEffect):
    """A motor that pulls in another proportion."""

    name = "actuator_gain"
    words = "a motor pulls more or less than it is told, in proportion"
    place = "motor"
    shown_by = FORCE
    may_sit_everywhere = False
    law = "actuator_gain"
    terms = law_terms("actuator_gain", "g")
    order = 13

    def true_numbers(self, parameters: Mapping[str, float], truth: Mapping[str, Any], place: int | None) -> Numbers:
        """The truth is a factor."""
        return {("g", place): parameters["written_over_true"] - 1.0}
