"""Cables that pull less when they are let go."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import TENSION_RATE


class CableHysteresis(LawEffect):
    """Cables that pull less when they are let go."""

    name = "cable_hysteresis"
    words = "the cables pull more on their way out than on their way back"
    place = "cable"
    shown_by = TENSION_RATE
    law = "cable_hysteresis"
    terms = law_terms("cable_hysteresis", "h")
    shape_terms = law_terms("cable_hysteresis", "xh")
    start_shapes = tuple({"xh": v} for v in (5e-5, 2e-4, 8e-4))
    may_sit_alone = False
    order = 17
