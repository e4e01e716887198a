"""Motors that follow late, or one of them."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import FORCE_RATE


class ActuatorLag(LawEffect):
    """Motors that follow late, or one of them."""

    name = "actuator_lag"
    words = "the motors follow their commands late"
    place = "motor"
    shown_by = FORCE_RATE
    law = "actuator_lag"
    terms = law_terms("actuator_lag", "taul")
    truth_names = (("taul", "tau"),)
    order = 15
