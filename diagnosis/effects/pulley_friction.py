"""Friction of cables on their pulleys."""

from diagnosis.effect import LawEffect, law_terms


class PulleyFriction(LawEffect):
    """Friction of cables on their pulleys."""

    name = "pulley_friction"
    words = "the cables rub on their pulleys, the more they are tensioned"
    place = "cable"
    law = "pulley_friction"
    terms = law_terms("pulley_friction", "mu")
    order = 4
