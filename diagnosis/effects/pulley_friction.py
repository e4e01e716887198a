"""Friction of cables on their pulleys."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import TENSION_ALONG_MOTION
from mechanism.laws.pulley_friction import SLIDING_M_S


class PulleyFriction(LawEffect):
    """Friction of cables on their pulleys."""

    name = "pulley_friction"
    words = "the cables rub on their pulleys, the more they are tensioned"
    place = "cable"
    shown_by = TENSION_ALONG_MOTION
    law = "pulley_friction"
    terms = law_terms("pulley_friction", "mu", "ma")
    shape_terms = law_terms("pulley_friction", "vp", "wm")
    start_shapes = ({"vp": SLIDING_M_S, "wm": 0.0},)
    order = 4
