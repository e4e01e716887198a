"""A motor that pulls without being told."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import FORCE


class ActuatorOffset(LawEffect):
    """A motor that pulls without being told."""

    name = "actuator_offset"
    words = "a motor pulls by a constant force more or less than it is told"
    place = "motor"
    shown_by = FORCE
    law = "actuator_offset"
    terms = law_terms("actuator_offset", "fo")
    truth_names = (("fo", "written_less_true"),)
    order = 14
