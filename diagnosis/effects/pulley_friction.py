"""Friction of cables on their pulleys."""

from diagnosis.effect import OfLaw, of_law


class PulleyFriction(OfLaw):
    """Friction of cables on their pulleys."""

    name = "pulley_friction"
    words = "the cables rub on their pulleys, the more they are tensioned"
    place = "cable"
    law = "pulley_friction"
    terms = of_law("pulley_friction", "mu")
