"""Friction that is larger near rest."""

from diagnosis.effect import OfLaw, of_law


class StribeckFriction(OfLaw):
    """Friction that is larger near rest."""

    name = "stribeck_friction"
    words = "the motors rub more when they turn slowly"
    place = "motor"
    law = "stribeck_friction"
    terms = of_law("stribeck_friction", "fst")
    forms = of_law("stribeck_friction", "vs", "ns")
    shapes = tuple({"vs": v, "ns": n} for v in (3.0, 6.0, 12.0, 25.0) for n in (1.0, 5.0))
