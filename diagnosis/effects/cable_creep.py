"""Cables that go on stretching."""

from diagnosis.effect import OfLaw, of_law


class CableCreep(OfLaw):
    """Cables that go on stretching."""

    name = "cable_creep"
    words = "the cables go on stretching under load, and come back slowly"
    place = "cable"
    law = "cable_creep"
    terms = of_law("cable_creep", "km")
    forms = of_law("cable_creep", "tau")
    shapes = tuple({"tau": v} for v in (0.5, 1.5, 4.0, 10.0))
    single = False
