"""Friction that bends before it slides."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import BENDING


class PreslidingFriction(LawEffect):
    """Friction that bends before it slides."""

    name = "presliding_friction"
    words = "the motors' friction bends before it slides: near a reversal it follows the angle, not the speed"
    place = "motor"
    shown_by = BENDING
    law = "presliding_friction"
    terms = law_terms("presliding_friction", "fp")
    shape_terms = law_terms("presliding_friction", "wp")
    start_shapes = tuple({"wp": v} for v in (0.01, 0.04, 0.16))
    order = 2
