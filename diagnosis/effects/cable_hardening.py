"""Cables that get stiffer under load."""

from collections.abc import Mapping
from typing import Any

from diagnosis.effect import LawEffect, Numbers, law_terms
from diagnosis.shown_by import TENSION
from mechanism.laws.hardening import AT_M


class CableHardening(LawEffect):
    """Cables that get stiffer under load."""

    name = "cable_hardening"
    words = "the cables get stiffer the more they are tensioned"
    place = "cable"
    shown_by = TENSION
    law = "cable_hardening"
    terms = law_terms("cable_hardening", "k2")
    shape_terms = law_terms("cable_hardening", "nh")
    start_shapes = tuple({"nh": n} for n in (2.0, 3.0))
    may_sit_alone = False
    order = 1

    def true_numbers(self, parameters: Mapping[str, float], truth: Mapping[str, Any], place: int | None) -> Numbers:
        """Of cubic hardening only, k3 x^3: all powers agree at AT_M; exponential hardening has another form."""
        cubic: Numbers = {
            ("k2", int(name.removeprefix("k3"))): AT_M * value
            for name, value in parameters.items()
            if name.startswith("k3")
        }
        return cubic | ({("nh", None): 3.0} if cubic else {})
