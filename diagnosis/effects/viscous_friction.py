"""Friction in proportion to speed."""

from diagnosis.effect import OfLaw, of_law


class ViscousFriction(OfLaw):
    """Friction in proportion to speed."""

    name = "viscous_friction"
    words = "the motors rub more the faster they turn"
    place = "motor"
    law = "viscous_friction"
    terms = of_law("viscous_friction", "fv")
