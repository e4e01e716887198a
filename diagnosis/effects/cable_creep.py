"""Cables that go on stretching."""

from collections.abc import Mapping
from typing import Any

from diagnosis.effect import LawEffect, Numbers, law_terms
from diagnosis.shown_by import TENSION_BEYOND_RECENT


class CableCreep(LawEffect):
    """Cables that go on stretching."""

    name = "cable_creep"
    words = "the cables go on stretching under load, and come back slowly"
    place = "cable"
    shown_by = TENSION_BEYOND_RECENT
    law = "cable_creep"
    terms = law_terms("cable_creep", "km")
    shape_terms = law_terms("cable_creep", "tau")
    start_shapes = tuple({"tau": v} for v in (0.5, 1.5, 4.0, 10.0))
    may_sit_alone = False
    order = 16

    def true_numbers(self, parameters: Mapping[str, float], truth: Mapping[str, Any], place: int | None) -> Numbers:
        """A Kelvin element in line with a spring is a Zener element beside one: k gives way to k / (1 + share)."""
        whole = 1 + parameters["share"]
        beside: Numbers = {("km", j + 1): k * parameters["share"] / whole for j, k in enumerate(truth["k"])}
        return {**beside, ("tau", None): parameters["tau"] / whole}
