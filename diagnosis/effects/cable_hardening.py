"""Cables that get stiffer under load."""

from diagnosis.effect import OfLaw, of_law


class CableHardening(OfLaw):
    """Cables that get stiffer under load."""

    name = "cable_hardening"
    words = "the cables get stiffer the more they are tensioned"
    place = "cable"
    law = "cable_hardening"
    terms = of_law("cable_hardening", "k2")
    forms = of_law("cable_hardening", "nh")
    shapes = tuple({"nh": n} for n in (2.0, 3.0))
    single = False
