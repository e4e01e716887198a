"""Friction that is larger near rest."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import MOTOR_SPEED


class StribeckFriction(LawEffect):
    """Friction that is larger near rest."""

    name = "stribeck_friction"
    words = "the motors rub more when they turn slowly"
    place = "motor"
    shown_by = MOTOR_SPEED
    law = "stribeck_friction"
    terms = law_terms("stribeck_friction", "fst")
    shape_terms = law_terms("stribeck_friction", "vs", "ns")
    start_shapes = tuple({"vs": v, "ns": n} for v in (3.0, 6.0, 12.0, 25.0) for n in (1.0, 5.0))
    truth_names = (("fst", "fb"),)
    order = 2
