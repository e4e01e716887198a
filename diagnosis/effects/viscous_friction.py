"""Friction in proportion to speed."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import MOTOR_SPEED


class ViscousFriction(LawEffect):
    """Friction in proportion to speed."""

    name = "viscous_friction"
    words = "the motors rub more the faster they turn"
    place = "motor"
    shown_by = MOTOR_SPEED
    law = "viscous_friction"
    terms = law_terms("viscous_friction", "fv")
    order = 3
