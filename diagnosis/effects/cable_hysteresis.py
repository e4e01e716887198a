"""Cables that pull less when they are let go."""

from diagnosis.effect import OfLaw, of_law


class CableHysteresis(OfLaw):
    """Cables that pull less when they are let go."""

    name = "cable_hysteresis"
    words = "the cables pull more on their way out than on their way back"
    place = "cable"
    law = "cable_hysteresis"
    terms = of_law("cable_hysteresis", "h")
    forms = of_law("cable_hysteresis", "xh")
    shapes = tuple({"xh": v} for v in (5e-5, 2e-4, 8e-4))
    single = False
