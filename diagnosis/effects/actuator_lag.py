"""Motors that follow late."""

from diagnosis.effect import LawEffect, law_terms
from diagnosis.shown_by import FORCE_RATE


class ActuatorLag(LawEffect):
    """Motors that follow late."""

    name = "actuator_lag"
    words = "the motors follow their commands late"
    place = "motor"
    shown_by = FORCE_RATE
    law = "actuator_lag"
    terms = law_terms("actuator_lag", "taul")
    may_sit_alone = False
    truth_names = (("taul", "tau"),)
    order = 15
